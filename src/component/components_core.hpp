#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string_view>
#include <vector>

#include "component/active_components.hpp"
#include "component/one_component.hpp"
#include "hgros/component/components.hpp"
#include "hgros/tf/transforms.hpp"

namespace hgros {

// Threading: as Components.
class Components::Core {
 public:
  Core(Session& session, ComponentsOptions options);
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;
  ~Core();

  // The registered type, if `type` is null.
  // `arrives`: from another place.
  OneComponent& Add(const ComponentType* type, const ComponentSetup& setup, bool arrives = false);
  void Join();
  void Join(OneComponent& one);
  void Start();
  void End(std::string_view name);
  void BeginEnd() noexcept { active_.BeginEnd(); }
  void ConstructAgain(std::string_view name, std::chrono::nanoseconds patience, const Components::SetupAgain& setup,
                      const Components::OnSaved& saved);

  [[nodiscard]] OneComponent* Find(std::string_view name);
  // Throws Error if there is none.
  [[nodiscard]] OneComponent& Get(std::string_view name);
  [[nodiscard]] const std::vector<std::unique_ptr<OneComponent>>& all() const noexcept { return all_; }
  // The channels on which `one` publishes, and no other component of this session.
  [[nodiscard]] std::vector<std::string> OwnOutputs(const OneComponent& one) const;
  // Whether something else of this session publishes on the channel, or did before it left.
  [[nodiscard]] bool HasPublisherBeside(const OneComponent& one, std::string_view channel) const;
  [[nodiscard]] Session& session() const noexcept { return session_; }
  [[nodiscard]] const ComponentsOptions& options() const noexcept { return options_; }

 private:
  Transforms& SharedTransforms();

  Session& session_;
  const ComponentsOptions options_;
  std::mutex transforms_mutex_;
  std::optional<Transforms> transforms_;
  ActiveComponents active_;
  std::vector<std::unique_ptr<OneComponent>> all_;
};

}  // namespace hgros

#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string_view>
#include <vector>

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
  OneComponent& Add(const ComponentType* type, const ComponentSetup& setup);
  void Join();
  void Join(OneComponent& one);
  void Start();
  void End(std::string_view name);
  void ConstructAgain(std::string_view name, std::chrono::nanoseconds patience, const Components::SetupAgain& setup,
                      const Components::OnSaved& saved);

  [[nodiscard]] OneComponent* Find(std::string_view name);
  // Throws Error if there is none.
  [[nodiscard]] OneComponent& Get(std::string_view name);
  [[nodiscard]] const std::vector<std::unique_ptr<OneComponent>>& all() const noexcept { return all_; }
  [[nodiscard]] Session& session() const noexcept { return session_; }
  [[nodiscard]] const ComponentsOptions& options() const noexcept { return options_; }

 private:
  Transforms& SharedTransforms();

  Session& session_;
  const ComponentsOptions options_;
  std::mutex transforms_mutex_;
  std::optional<Transforms> transforms_;
  std::vector<std::unique_ptr<OneComponent>> all_;
};

}  // namespace hgros

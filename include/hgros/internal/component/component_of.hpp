#pragma once

#include <concepts>
#include <memory>
#include <type_traits>
#include <typeinfo>
#include <utility>

#include "hgros/codec/message.hpp"
#include "hgros/component/context.hpp"

namespace hgros {

template <class C>
inline constexpr bool kActivates = requires(C& component) {
  { component.Activate() } -> std::same_as<void>;
};
template <class C>
inline constexpr bool kDeactivates = requires(C& component) {
  { component.Deactivate() } -> std::same_as<void>;
};
template <class C>
inline constexpr bool kSaves = requires(C& component) {
  component.Save();
};

template <class C>
struct SavedBy {
  using Type = void;
};
template <class C>
requires kSaves<C>
struct SavedBy<C> {
  using Type = std::remove_cvref_t<decltype(std::declval<C&>().Save())>;
};
template <class C>
using StateOf = typename SavedBy<C>::Type;

// With Save, its type; without, any argument of a Restore: a conversion to everything.
struct AnyState {
  template <class T>
  operator const T&() const;  // NOLINT(google-explicit-constructor): stands for the unknown argument.
};
template <class C>
inline constexpr bool kRestores = requires(C& component, std::conditional_t<kSaves<C>, StateOf<C>, AnyState> state) {
  component.Restore(std::as_const(state));
};

/// A component whose class is known to the library that it comes from.
class AnyComponent {
 public:
  AnyComponent() = default;
  AnyComponent(const AnyComponent&) = delete;
  AnyComponent& operator=(const AnyComponent&) = delete;
  virtual ~AnyComponent() = default;

  virtual void Activate() = 0;
  virtual void Deactivate() = 0;
  /// Null if the class has no Save.
  [[nodiscard]] virtual AnyMessage Save() = 0;
  /// `state` is of the type ComponentType::state.
  virtual void Restore(const AnyMessage& state) = 0;
  [[nodiscard]] virtual void* object() noexcept = 0;
  [[nodiscard]] virtual const std::type_info& type() const noexcept = 0;
};

template <class C>
class ComponentOf final : public AnyComponent {
 public:
  explicit ComponentOf(Context& context) : component_(context) {}

  void Activate() override {
    if constexpr (kActivates<C>) component_.Activate();
  }
  void Deactivate() override {
    if constexpr (kDeactivates<C>) component_.Deactivate();
  }
  [[nodiscard]] AnyMessage Save() override {
    if constexpr (kSaves<C>) {
      return std::make_shared<const StateOf<C>>(component_.Save());
    } else {
      return nullptr;
    }
  }
  void Restore(const AnyMessage& state) override {
    if constexpr (kSaves<C>) component_.Restore(*static_cast<const StateOf<C>*>(state.get()));
  }
  [[nodiscard]] void* object() noexcept override { return &component_; }
  [[nodiscard]] const std::type_info& type() const noexcept override { return typeid(C); }

 private:
  C component_;
};

template <class C>
[[nodiscard]] std::unique_ptr<AnyComponent> ConstructComponent(Context& context) {
  return std::make_unique<ComponentOf<C>>(context);
}

}  // namespace hgros

#pragma once

#include <cstddef>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "hgros/codec/raw_message.hpp"
#include "viewer/data/messages/field_path.hpp"
#include "viewer/data/messages/number_series.hpp"
#include "viewer/data/messages/schema_book.hpp"

namespace hgros::viewer {

/// Reads some numbers from each message of a channel of any type and keeps them over time. Thread-safe.
class NumberFeed {
 public:
  explicit NumberFeed(Duration kept) : kept_(kept) {}

  void Add(const RawMessage& message, Time at);

  /// Adds a path, as FieldPath reads it, unless it is already watched.
  void Watch(const std::string& path);
  void Forget(const std::string& path);
  void Clear();

  struct View {
    std::vector<NumberSeries::Column> columns;
    std::optional<double> newest;
    std::string fault;  ///< Why there is no number. Empty: nothing is wrong, or no message has arrived.
  };
  [[nodiscard]] View Look(const std::string& path, Time from, Time to, std::size_t columns) const;
  /// When the newest number of the path arrived; none if there is no number.
  [[nodiscard]] std::optional<Time> Newest(const std::string& path) const;
  /// The paths that could be watched. Empty until a message has arrived.
  [[nodiscard]] std::vector<std::string> Paths() const;
  /// Why the messages cannot be read. Empty: they can be, or none has arrived.
  [[nodiscard]] std::string fault() const;

 private:
  static constexpr std::size_t kMostValues = 200'000;
  static constexpr std::size_t kMostPaths = 400;

  struct Watched {
    std::string path;
    std::optional<FieldPath> field;
    std::string fault;
    NumberSeries numbers;
  };
  [[nodiscard]] const Watched* Find(const std::string& path) const;
  void Resolve(Watched& watched) const;

  const Duration kept_;
  mutable std::mutex mutex_;
  SchemaBook schemas_;
  std::shared_ptr<const DynamicSchema> type_;
  std::string fault_;
  std::vector<Watched> watched_;
};

}  // namespace hgros::viewer

#include "hgros/codec/packed_elements.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace hgros {
namespace {

std::string TypeName(int type) {
  static constexpr std::array<const char*, 9> kNames{
      "values of an unknown type", "UINT8", "INT8", "UINT16", "INT16", "UINT32", "INT32", "FLOAT32", "FLOAT64"};
  if (type >= 0 && static_cast<std::size_t>(type) < kNames.size()) return kNames[static_cast<std::size_t>(type)];
  return "values of type " + std::to_string(type) + ", which does not exist";
}

std::string Quoted(std::string_view name) { return "\"" + std::string(name) + "\""; }

}  // namespace

ViewResult<PackedElements> PackedElements::Of(Bytes data, std::uint64_t stride_bytes,
                                              std::vector<ElementField> fields) {
  const std::string size = std::to_string(data.size()) + " bytes";
  if (stride_bytes == 0) return ViewResult<PackedElements>::Fault("The " + size + " have a stride of 0.");
  if (data.size() % stride_bytes != 0) {
    return ViewResult<PackedElements>::Fault("The " + size + " are not a whole number of elements of " +
                                             std::to_string(stride_bytes) + " bytes.");
  }
  return PackedElements(data, static_cast<std::size_t>(stride_bytes), std::move(fields));
}

std::string PackedElements::Find(std::string_view name, NumericType type, std::size_t size_bytes,
                                 std::size_t& offset_bytes) const {
  const auto field = std::ranges::find(fields_, name, &ElementField::name);
  if (field == fields_.end()) {
    std::string known;
    for (const ElementField& one : fields_) known += (known.empty() ? "" : ", ") + one.name;
    return "There is no field " + Quoted(name) +
           (known.empty() ? ": there are no fields." : "; there are: " + known + ".");
  }
  if (field->type != static_cast<int>(type)) {
    return "Field " + Quoted(name) + " holds " + TypeName(field->type) + ", not " + TypeName(static_cast<int>(type)) +
           ".";
  }
  if (field->offset_bytes > stride_ || stride_ - field->offset_bytes < size_bytes) {
    return "Field " + Quoted(name) + " begins at byte " + std::to_string(field->offset_bytes) + " and has " +
           std::to_string(size_bytes) + " bytes, but an element has only " + std::to_string(stride_) + ".";
  }
  offset_bytes = static_cast<std::size_t>(field->offset_bytes);
  return {};
}

}  // namespace hgros

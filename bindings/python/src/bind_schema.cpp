#include <memory>
#include <string>

#include "bindings.hpp"
#include "hgros/codec/dynamic_schema.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/codec/schema_match.hpp"

namespace hgros::python {
namespace {

std::shared_ptr<MessageSchema> Named(const std::string& type_name, const py::bytes& descriptor_set) {
  return std::make_shared<MessageSchema>(
      NamedSchema({type_name, Encoding::kProtobuf, 0, static_cast<std::string>(descriptor_set)}));
}

// Python's own reader of descriptors trusts them; those of other sessions may contain anything.
std::string FaultOf(const MessageSchema& schema) {
  std::string fault;
  return DynamicSchema::Build(schema, fault) ? std::string() : fault;
}

}  // namespace

void BindSchema(py::module_& module) {
  py::class_<MessageSchema, std::shared_ptr<MessageSchema>>(module, "Schema", "A type of messages on the wire.")
      .def(py::init(&Named), py::arg("type_name"), py::arg("descriptor_set"))
      .def_readonly("type_name", &MessageSchema::type_name)
      .def_property_readonly("is_protobuf",
                             [](const MessageSchema& schema) { return schema.encoding == Encoding::kProtobuf; })
      .def_readonly("fingerprint", &MessageSchema::fingerprint)
      .def_property_readonly("descriptor_set",
                             [](const MessageSchema& schema) { return py::bytes(schema.descriptor_set); })
      .def("fault", &FaultOf, "Why it does not describe a type; empty if it does.")
      .def(
          "misfit", [](const MessageSchema& theirs, const MessageSchema& ours) { return MisfitOf(theirs, ours); },
          py::arg("ours"), "Why messages of this type cannot be read as `ours`; empty if they can.");
}

}  // namespace hgros::python

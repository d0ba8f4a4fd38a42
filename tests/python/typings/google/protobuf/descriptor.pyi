class FileDescriptor:
    name: str
    package: str
    serialized_pb: bytes
    dependencies: list[FileDescriptor]

class FieldDescriptor:
    TYPE_BYTES: int
    LABEL_REPEATED: int
    name: str
    number: int
    type: int
    label: int
    containing_oneof: object

class Descriptor:
    full_name: str
    file: FileDescriptor
    fields: list[FieldDescriptor]

class EnumDescriptor: ...

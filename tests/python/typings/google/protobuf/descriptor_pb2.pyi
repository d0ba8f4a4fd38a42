from typing import Any

from google.protobuf.message import Message

class FileDescriptorSet(Message):
    file: list[Any]

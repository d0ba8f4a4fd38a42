from google.protobuf.descriptor import Descriptor
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message import Message

class MessageFactory:
    def __init__(self, pool: DescriptorPool) -> None: ...
    def GetPrototype(self, descriptor: Descriptor) -> type[Message]: ...

#include <foxglove/PoseInFrame.pb.h>
#include <hgros/component/component.hpp>

namespace {

struct Source {
  explicit Source(hgros::Context& context) : poses(context.Advertise<foxglove::PoseInFrame>("pose")) {}
  hgros::Publisher<foxglove::PoseInFrame> poses;
};
struct Sink {
  explicit Sink(hgros::Context& context) {
    context.FromAny<foxglove::PoseInFrame>("pose", hgros::Invoke::kSerial, [](const foxglove::PoseInFrame&) {});
  }
};
struct First {
  explicit First(hgros::Context&) {}
};
struct Second {
  explicit Second(hgros::Context&) {}
};

}  // namespace

HGROS_COMPONENT(Source, "library/Source")
HGROS_COMPONENT(Sink, "library/Sink")
HGROS_COMPONENT(First, "library/Twice")
HGROS_COMPONENT(Second, "library/Twice")
HGROS_COMPONENT(First, "library/bad name")

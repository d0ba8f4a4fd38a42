// Does not compile: each of these types is refused with one sentence (see check.cmake).
#include <memory>
#include <string>
#include <vector>

#include "hgros/hgros.hpp"

struct WithString {
  int id = 0;
  std::string name;
};
struct WithPointer {
  const double* range = nullptr;
};
struct WithVector {
  std::vector<float> ranges;
};
class WithSecret {
 public:
  explicit WithSecret(int value) : value_(value) {}

 private:
  int value_;
};

void Use(hgros::Session& session) {
  const auto subscription = session.FromAny<WithString>("a", hgros::Invoke::kSerial, [](const WithString&) {});
  const auto publish = session.Advertise<WithPointer>("b");
  session.ToAny("c", std::make_unique<WithVector>());
  session.ToAny("d", WithSecret(1));
  session.ToAny("e", std::make_shared<std::string>());
  hgros::FromAny<std::wstring>("f", hgros::Invoke::kSerial, [](const std::wstring&) {});
}

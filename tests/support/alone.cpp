// Linked into every test program: its sessions neither find nor are found by others of this host, unless a test says
// so, or the environment does. Programs that the test starts inherit it.
#include <cstdlib>

namespace hgros::test {
namespace {

[[maybe_unused]] const int alone = setenv("HGROS_DOMAIN", "none", 0);

}  // namespace
}  // namespace hgros::test

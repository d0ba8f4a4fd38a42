// Linked into every test program. Its sessions do not discover other sessions on this host, nor are they discovered,
// unless the test or the environment changes that. Programs that the test starts inherit it.
#include <cstdlib>

namespace hgros::test {
namespace {

[[maybe_unused]] const int alone = setenv("HGROS_DOMAIN", "none", 0);

}  // namespace
}  // namespace hgros::test

#include <hgros/hgros.hpp>

int NothingToLoad() { return 0; }

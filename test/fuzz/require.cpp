#include <cstdio>
#include <cstdlib>

#include "test/fuzz/target.hpp"

namespace extperfc::fuzz {

void require(bool kept, const char* promise) {
  if (kept) return;
  std::fprintf(stderr, "broken promise: %s\n", promise);
  std::abort();
}

}  // namespace extperfc::fuzz

#include "core/check.h"

#include <cstdio>
#include <cstdlib>

namespace virtdrive {

void check_failed(const char* file, int line, const char* condition, std::string_view message) {
  fmt::print(stderr, "{}:{}: check failed: {}: {}\n", file, line, condition, message);
  std::abort();
}

}  // namespace virtdrive

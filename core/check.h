// The two ways in which things go wrong outside of a simulated world.
//
//   VIRTDRIVE_CHECK   a mistake of the programmer: always on, prints the values, aborts.
//   SetupError        a mistake in what the user gave us (option, file, port): one clear line that
//   says
//                     what was expected and what to do; caught once, in main.
//
// Bad bytes on a line are neither: they are data (a decode-error value). A drive's trip is a
// latched fault of its firmware model.
#pragma once

#include <fmt/core.h>
#include <stdexcept>
#include <string>
#include <string_view>

namespace virtdrive {

class SetupError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

[[noreturn]] void check_failed(const char* file, int line, const char* condition,
                               std::string_view message);

}  // namespace virtdrive

#define VIRTDRIVE_CHECK(condition, ...)                                                    \
  do {                                                                                     \
    if (!(condition)) [[unlikely]]                                                         \
      ::virtdrive::check_failed(__FILE__, __LINE__, #condition, fmt::format(__VA_ARGS__)); \
  } while (false)

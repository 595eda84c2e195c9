// The files of data/motors/, in the program since it was built.
#pragma once

#include <span>
#include <string_view>

namespace virtdrive {

struct EmbeddedFile {
  std::string_view name;  // "db42s03.yaml"
  std::string_view text;
};

/// In the order of their names.
std::span<const EmbeddedFile> motor_data();

}  // namespace virtdrive

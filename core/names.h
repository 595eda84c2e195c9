// Help for people who mistype a name.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace virtdrive {

/// Edits (insert, delete, replace, swap of neighbours) between two names, case ignored.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// "unknown motor 'db42s30'; did you mean db42s03? (known: ...)": nearest names first, all of them
/// when they are few.
std::string unknown_name(std::string_view kind, std::string_view name,
                         const std::vector<std::string_view>& known);

}  // namespace virtdrive

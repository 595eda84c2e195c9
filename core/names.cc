#include "core/names.h"

#include <algorithm>
#include <cctype>
#include <fmt/format.h>

namespace virtdrive {
namespace {

constexpr std::size_t kListAtMost = 12;
constexpr std::size_t kOfferAtMost = 3;

bool same_letter(char a, char b) {
  return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
}

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
  // Optimal string alignment with three rows: d(i,j) needs rows i, i-1 and i-2.
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before.swap(last);
    last.swap(row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = last[j - 1] + (same_letter(a[i - 1], b[j - 1]) ? 0 : 1);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, replaced});
      if (i > 1 && j > 1 && same_letter(a[i - 1], b[j - 2]) && same_letter(a[i - 2], b[j - 1])) {
        row[j] = std::min(row[j], before[j - 2] + 1);
      }
    }
  }
  return row[b.size()];
}

std::string unknown_name(std::string_view kind, std::string_view name,
                         const std::vector<std::string_view>& known) {
  std::string text = fmt::format("unknown {} '{}'", kind, name);
  std::vector<std::pair<std::size_t, std::string_view>> near;
  for (const std::string_view candidate : known) {
    // A name that was cut short is nearer than any misspelling.
    const bool begins = name.size() >= 3 && candidate.starts_with(name);
    const std::size_t distance = begins ? 0 : edit_distance(name, candidate);
    if (distance <= std::max<std::size_t>(2, candidate.size() / 3))
      near.emplace_back(distance, candidate);
  }
  std::ranges::stable_sort(near, {}, &std::pair<std::size_t, std::string_view>::first);
  for (std::size_t i = 0; i < std::min(near.size(), kOfferAtMost); ++i) {
    text += fmt::format("{}{}", i == 0 ? "; did you mean " : " or ", near[i].second);
  }
  if (!near.empty()) text += '?';
  if (known.size() <= kListAtMost) text += fmt::format(" (known: {})", fmt::join(known, ", "));
  return text;
}

}  // namespace virtdrive

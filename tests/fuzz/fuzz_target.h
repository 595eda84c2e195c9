// What every fuzz target is made of: the function that takes any bytes, and inputs to begin with,
// for libFuzzer's corpus and for the taste of the fuzzer that every build's tests have.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace virtdrive {

std::vector<std::vector<std::uint8_t>> fuzz_seeds();

}  // namespace virtdrive

// The `bench:` of a scenario file.
#pragma once

#include "core/yaml_reader.h"
#include "scenarios/bench.h"

namespace virtdrive {

/// SetupError at the place of what does not exist.
BenchOptions read_bench(const YamlValue& value);

/// The parameters that its drives start with: tried on `bench`, which has been built from
/// `options`, and added to these.
void read_start_parameters(const YamlValue& value, Bench& bench, BenchOptions& options);

/// Refuses what is in braces in a host's command and is none of {port}, {port:LINE}.
void check_placeholders(const YamlValue& value, std::string_view command,
                        const BenchOptions& options);

}  // namespace virtdrive

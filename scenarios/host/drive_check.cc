#include "scenarios/host/drive_check.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/check.h"
#include "scenarios/report/junit.h"

namespace virtdrive {
namespace {

using Json = nlohmann::ordered_json;
using protocol::Check;

class TimedTransport final : public HostTransport {
 public:
  TimedTransport(HostTransport& transport, const std::function<SimDuration()>& now)
      : transport_(transport), now_(now) {}

  void write(std::span<const std::uint8_t> bytes) override {
    transport_.write(bytes);
    asked_ = now_();
  }
  std::optional<std::uint8_t> read(SimDuration patience) override {
    const auto byte = transport_.read(patience);
    if (byte && asked_) latencies_.all.push_back(now_() - *asked_);
    if (byte) asked_.reset();
    return byte;
  }
  Latencies latencies() && {
    std::ranges::sort(latencies_.all);
    return std::move(latencies_);
  }

 private:
  HostTransport& transport_;
  const std::function<SimDuration()>& now_;
  std::optional<SimDuration> asked_;  // since when an answer is waited for
  Latencies latencies_;
};

double milliseconds(SimDuration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

std::string requirement(const Check& check) {
  return check.source.empty() ? check.what : fmt::format("{} ({})", check.what, check.source);
}

}  // namespace

SimDuration Latencies::quantile(double share) const {
  VIRTDRIVE_CHECK(!all.empty(), "no answer was measured");
  const auto last = static_cast<double>(all.size() - 1);
  return all[static_cast<std::size_t>(std::lround(share * last))];
}

DriveCheck check_drive(const protocol::Dialect& dialect, HostTransport& transport,
                       const std::function<SimDuration()>& now,
                       const protocol::WalkOptions& options) {
  TimedTransport timed(transport, now);
  DriveCheck check{.walk = protocol::walk(dialect, timed, options), .latencies = {}};
  check.latencies = std::move(timed).latencies();
  return check;
}

std::string text(const DriveCheck& check) {
  std::string text = protocol::text(check.walk);
  if (check.latencies.all.empty()) return text;
  return text + fmt::format(
                    "answers begin after {:.3f} ms at the earliest, {:.3f} ms in the middle, "
                    "{:.3f} ms in 99 of 100, {:.3f} ms at the latest ({} measured)\n",
                    milliseconds(check.latencies.all.front()),
                    milliseconds(check.latencies.quantile(0.5)),
                    milliseconds(check.latencies.quantile(0.99)),
                    milliseconds(check.latencies.all.back()), check.latencies.all.size());
}

std::string check_junit(const DriveCheck& check, std::string_view protocol) {
  std::vector<JunitCase> cases;
  for (const Check& one : check.walk.checks) {
    if (cases.empty() || cases.back().name != one.row) {
      cases.push_back({.name = one.row, .group = std::string(protocol)});
    }
    if (one.passed) continue;
    JunitCase& row = cases.back();
    if (row.summary.empty()) row.summary = requirement(one);
    row.text += fmt::format("{}: {}\n", requirement(one), one.detail);
  }
  return junit(cases);
}

std::string check_json(const DriveCheck& check, std::string_view protocol) {
  Json checks = Json::array();
  for (const Check& one : check.walk.checks) {
    Json json = {
        {"row", one.row}, {"what", one.what}, {"source", one.source}, {"passed", one.passed}};
    if (!one.passed) json["detail"] = one.detail;
    checks.push_back(std::move(json));
  }
  Json json = {{"protocol", protocol},
               {"checks", check.walk.checks.size()},
               {"failures", check.walk.failures()},
               {"given_up", check.walk.given_up},
               {"skipped", check.walk.skipped}};
  if (!check.latencies.all.empty()) {
    json["latency_ms"] = {{"minimum", milliseconds(check.latencies.all.front())},
                          {"median", milliseconds(check.latencies.quantile(0.5))},
                          {"p99", milliseconds(check.latencies.quantile(0.99))},
                          {"maximum", milliseconds(check.latencies.all.back())}};
  }
  json["results"] = std::move(checks);
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace virtdrive

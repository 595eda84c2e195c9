// MD controllers on a CAN bus behind an SLCAN adapter, and at their TTL port.
#include <gtest/gtest.h>

#include "core/yaml_reader.h"
#include "devices/md485/can_codec.h"
#include "devices/md485/client.h"
#include "devices/slcan/codec.h"
#include "scenarios/bench.h"
#include "scenarios/line_transport.h"
#include "scenarios/scenario/bench_reader.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using namespace md485;

const CommandRow& command(std::uint16_t pid) {
  return *protocol::find(kTable.commands, pid);
}
const ParameterRow& row(std::uint16_t pid) {
  return *protocol::find(kTable.parameters, pid);
}

// A host at the adapter's serial end.
class SlcanHost {
 public:
  explicit SlcanHost(Bench& bench) : transport_(bench.loop(), bench.line("can")) {}

  void say(std::string line) {
    line += '\r';
    transport_.write(std::span(reinterpret_cast<const std::uint8_t*>(line.data()), line.size()));
  }
  /// Up to the next CR or BELL; "" for silence.
  std::string hear(SimDuration patience = 50ms) {
    std::string text;
    while (const auto byte = transport_.read(patience)) {
      text += static_cast<char>(*byte);
      if (*byte == slcan::kOk || *byte == slcan::kError) break;
    }
    return text;
  }
  std::string ask(const std::string& line) {
    say(line);
    return hear();
  }
  void open(const std::string& rate = "S2") {
    EXPECT_EQ(ask(rate), "\r");
    EXPECT_EQ(ask("O"), "\r");
  }
  /// The answer behind the adapter's own Z.
  std::string request(Route route, std::uint8_t pid) {
    EXPECT_EQ(ask(slcan::text_of(can_request(route, command(4), {pid}))), "Z\r");
    return hear();
  }

 private:
  LineTransport transport_;
};

DriveSpec on_can(std::string kind, std::string name, std::vector<std::string> set = {}) {
  return {.kind = std::move(kind),
          .name = std::move(name),
          .other_lines = {"", "can"},
          .set = std::move(set)};
}

TEST(MdCan, AControllerAnswersThroughAnAdapter) {
  Bench bench({.drives = {on_can("md400t", "")},
               .lines = {{.name = "rs485"}, {.name = "can"}},
               .integrator = Integrator::kFast});
  SlcanHost host(bench);
  host.open();
  EXPECT_EQ(host.request({}, 1), "T00ACB7012012C\r");
  host.ask(slcan::text_of(can_request({}, command(130), {500})));
  bench.run_for(2s);
  EXPECT_NEAR(bench.read("motor0.speed"), 500, 15);
  EXPECT_GE(bench.read("can.frames"), 3);
  EXPECT_EQ(bench.read("can.errors"), 0);
  bench.registry().inject("can.bus_cut");
  EXPECT_EQ(host.request({}, 1), "");
  bench.registry().clear("can.bus_cut");
  EXPECT_EQ(host.hear(), "T00ACB7012012C\r");  // it was sent again
}

TEST(MdCan, TwoControllersShareTheBusAndItsBitRateIsThatOfTheLastPowerUp) {
  Bench bench({.drives = {on_can("md400t", "a"), on_can("md750", "b", {"ID=2", "ECAN_BITRATE=4"})},
               .lines = {{.name = "rs485"}, {.name = "can"}},
               .integrator = Integrator::kFast});
  // The second one was set to 500 kbit/s before its first power-up; so is now the first one.
  LineTransport transport(bench.loop(), bench.line());
  Client client(transport);
  client.write(row(137), {4});
  EXPECT_EQ(client.read(row(137))[0], 4);
  {
    SlcanHost host(bench);
    host.open("S2");
    EXPECT_EQ(host.request({.id = 2}, 133), "");  // at 500 kbit/s: an error to all others
    host.ask("C");
    host.open("S6");
    bench.run_for(100ms);
    bench.drive("a").reset();
    bench.drive("b").reset();
    EXPECT_EQ(host.request({.id = 1}, 133),
              "T00ACB7012"
              "8501\r");
    EXPECT_EQ(host.request({.id = 2}, 133),
              "T00ACB7022"
              "8502\r");
  }
}

TEST(MdCan, WhatIsHeardOnCanIsResentOnRs485) {
  Bench bench({.drives = {on_can("md1k", "")},
               .lines = {{.name = "rs485"}, {.name = "can"}},
               .integrator = Integrator::kFast});
  SlcanHost can(bench);
  can.open();
  LineTransport transport(bench.loop(), bench.line("rs485"));
  Client rs485(transport);
  rs485.command(command(10), {23});
  bench.run_for(50ms);
  EXPECT_EQ(can.ask("T01234567"
                    "3A1B2C3"),
            "Z\r");
  const protocol::Values heard = rs485.receive(row(238));
  EXPECT_EQ(heard[0], 0x01234567);
  EXPECT_EQ(heard[1], 0xA1);
  EXPECT_EQ(heard[3], 0xC3);
}

TEST(MdCan, APortThatIsNotThereOrNotOfThatKindIsRefused) {
  const auto error_of = [](const BenchOptions& options) -> std::string {
    try {
      Bench bench(options);
    } catch (const SetupError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(
      error_of({.drives = {on_can("md200", "x")}, .lines = {{.name = "rs485"}, {.name = "can"}}}),
      "");
  DriveSpec serial{.kind = "md400", .name = "y", .line = "can"};
  EXPECT_NE(error_of({.drives = {on_can("md400t", "x"), serial},
                      .lines = {{.name = "rs485"}, {.name = "can"}}})
                .find("port rs485 cannot be on 'can'"),
            std::string::npos);
}

TEST(MdCan, AScenariosBenchNamesTheLinesOfFurtherPorts) {
  const auto read = [](std::string_view text) {
    return read_bench(YamlFile("a.yaml", text).root());
  };
  const BenchOptions options = read(
      "lines: [{name: rs485}, {name: bus}, {name: ttl}]\n"
      "drive: md1k\n"
      "ports: {can: bus, ttl232: ttl}\n");
  EXPECT_EQ(options.drives[0].other_lines, (std::vector<std::string>{"ttl", "bus"}));
  Bench bench(options);
  EXPECT_EQ(bench.protocol_of("bus"), "slcan");
  EXPECT_EQ(bench.protocol_of("ttl"), "md485");
  const auto error_of = [&](std::string_view text) -> std::string {
    try {
      read(text);
    } catch (const SetupError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(error_of("drive: md200\nports: {can: line}\n").find("further port"), std::string::npos);
  EXPECT_NE(error_of("drive: md1k\nports: {can: bux}\n").find("'bux'"), std::string::npos);
}

TEST(MdTtl, TheSecondPortTalksAt9600BaudWhateverTheOthersDoes) {
  Bench bench({.drives = {{.kind = "md400", .other_lines = {"ttl"}, .set = {"BAUDRATE=5"}}},
               .lines = {{.name = "rs485"}, {.name = "ttl"}},
               .integrator = Integrator::kFast});
  EXPECT_EQ(bench.line("ttl").settings().baud, 9600);
  EXPECT_EQ(bench.line("rs485").settings().baud, 115200);
  EXPECT_EQ(bench.protocol_of("ttl"), "md485");
  LineTransport ttl(bench.loop(), bench.line("ttl"));
  LineTransport rs485(bench.loop(), bench.line("rs485"));
  Client first(rs485), second(ttl);
  second.command(command(130), {400});
  bench.run_for(2s);
  EXPECT_NEAR(double(first.read(row(138))[0]), 400, 15);
  EXPECT_NEAR(double(second.read(row(138))[0]), 400, 15);
  bench.drive().power_off();
  EXPECT_THROW(second.read(row(138)), DriveSilent);
  bench.drive().power_on();
  EXPECT_EQ(second.read(row(1))[0], 44);
}

}  // namespace
}  // namespace virtdrive

// The protocol as one controller speaks it: the rows of table.h with what the model and the
// firmware's profile change of them.
//
//   const ModelTable table(*md::models().begin(), Profile::kToday);
//   table.parameter(193)->fields
//
// A row that the controller has not is Support::kRejected here: it is silent there.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "devices/md485/table.h"
#include "firmware_models/md/model.h"

namespace virtdrive::md485 {

/// Which firmware a controller has: what it says beyond V4.4, and what it leaves unsaid.
enum class Profile : std::uint8_t {
  kToday,   // V4.4 with what hosts of today need: PID 193 with 17 bytes, later PIDs
  kStrict,  // "4.4-strict": the document and nothing else
  kV72,     // "v7.2": as kToday, silent on PIDs that a real v7.2 was silent on
};

/// "default", "4.4-strict", "v7.2"; SetupError for anything else.
Profile parse_profile(std::string_view text);

class ModelTable {
 public:
  ModelTable(const md::Model& model, Profile profile);
  ModelTable(const ModelTable&) = delete;
  ModelTable& operator=(const ModelTable&) = delete;

  const ProtocolTable& table() const { return table_; }
  /// Rows that the controller has; null otherwise.
  const ParameterRow* parameter(std::uint8_t pid) const;
  const CommandRow* command(std::uint8_t pid) const;
  const CommandRow* number(std::uint8_t cmd) const;

  const md::Model& model() const { return model_; }
  /// "MD400T-V4.4"
  const std::string& type_text() const { return type_text_; }

 private:
  void adapt(ParameterRow& row) const;

  const md::Model& model_;
  Profile profile_;
  std::string type_text_;
  std::string title_;
  std::vector<ParameterRow> parameters_;
  std::vector<CommandRow> commands_;
  std::vector<CommandRow> numbers_;
  ProtocolTable table_ = kTable;
};

/// Fields of a PID's value when it is written: behind the check byte where there is one.
std::vector<Field> write_fields(const ParameterRow& row);

}  // namespace virtdrive::md485

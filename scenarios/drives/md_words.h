// What users and scenarios write of an MD controller, in the words of its table: "MAX_RPM=1500".
#pragma once

#include <memory>
#include <string_view>

#include "devices/host_transport.h"
#include "devices/md485/table.h"
#include "scenarios/host_client.h"

namespace virtdrive {

struct MdAssignment {
  const md485::ParameterRow* row;
  protocol::Values
      values;  // of the row's write_fields(): the check byte is there where one belongs
};

/// NAME=VALUE[,VALUE...] with or without "PID_"; SetupError that names the part that is wrong.
MdAssignment parse_md_assignment(std::string_view text);

std::unique_ptr<HostClient> make_md_host(std::unique_ptr<HostTransport> transport);

}  // namespace virtdrive

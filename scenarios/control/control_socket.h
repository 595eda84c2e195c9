// A Unix socket on which a bench takes requests while it runs, a line each (control_commands.h).
// Only its owner may open it. Several clients at once; nothing here waits for one.
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <string>
#include <string_view>

#include "pty/file_descriptor.h"
#include "pty/host_endpoint.h"

namespace virtdrive {

class ControlSocket final : public HostEndpoint {
 public:
  static constexpr std::size_t kMostClients = 16;
  /// Bytes of a request, and of answers that a client has not read; who exceeds them is cut off.
  static constexpr std::size_t kMostRequest = 64 * 1024;
  static constexpr std::size_t kMostPending = 4 * 1024 * 1024;

  using Answer = std::function<std::string(std::string_view request)>;

  /// Listens at `path`; takes over what a bench that is gone has left there. SetupError if
  /// something else is there, or it cannot be had.
  ControlSocket(const std::string& path, Answer answer);
  ControlSocket(const ControlSocket&) = delete;
  ControlSocket& operator=(const ControlSocket&) = delete;
  ~ControlSocket() override;

  int fd() const override { return epoll_.get(); }
  void readable() override;
  void flush() override {}  // answers leave as soon as they can

 private:
  struct Client {
    FileDescriptor fd;
    std::string heard;
    std::string pending;
    bool gone = false;
  };

  void accept_clients();
  void serve(Client& client);
  void write(Client& client);
  void watch(int fd, unsigned events, int operation);

  std::string path_;
  Answer answer_;
  FileDescriptor listener_;
  FileDescriptor epoll_;
  std::list<Client> clients_;
};

/// Sends one request to the bench at `path` and returns its answer; SetupError if nobody is there
/// or the answer does not come whole.
std::string ask_control_socket(const std::string& path, std::string_view request);

}  // namespace virtdrive

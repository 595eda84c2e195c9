#include "pty/port_link.h"

#include <fstream>
#include <gtest/gtest.h>
#include <string>

#include "core/check.h"
#include "tests/pty/child_process.h"
#include "tests/pty/temporary_folder.h"

namespace virtdrive {
namespace {

namespace fs = std::filesystem;

/// The refusal's text; empty if the link could be made.
std::string refusal(const fs::path& path, const std::string& target = "/dev/pts/123") {
  try {
    const PortLink link{path, target};
  } catch (const SetupError& error) {
    return error.what();
  }
  return "";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

std::string lock_of(const fs::path& path) {
  return path.string() + ".lock";
}

TEST(PortLink, IsALinkToTheTerminalWhileItLivesAndLeavesNothing) {
  const TemporaryFolder folder;
  const fs::path path = folder / "drive";
  {
    const PortLink link{path, "/dev/pts/123"};
    EXPECT_EQ(link.path(), path);
    EXPECT_EQ(fs::read_symlink(path), "/dev/pts/123");
    EXPECT_TRUE(fs::exists(lock_of(path)));
  }
  EXPECT_FALSE(fs::is_symlink(fs::symlink_status(path)));
  EXPECT_FALSE(fs::exists(lock_of(path)));
}

TEST(PortLink, ARelativeNameStaysTheSameLinkWhenTheWorkingFolderChanges) {
  const TemporaryFolder folder;
  const fs::path before = fs::current_path();
  fs::current_path(folder / "");
  {
    const PortLink link{"drive", "/dev/pts/123"};
    fs::current_path(before);
    EXPECT_TRUE(fs::is_symlink(folder / "drive"));
    EXPECT_EQ(link.path(), fs::canonical(folder / "") / "drive");
  }
  EXPECT_FALSE(fs::is_symlink(folder / "drive"));
}

TEST(PortLink, RefusesARealFileAndLeavesIt) {
  const TemporaryFolder folder;
  std::ofstream{folder / "drive"} << "mine";
  EXPECT_TRUE(contains(refusal(folder / "drive"), "a file that virtdrive did not make is there"));
  EXPECT_EQ(fs::file_size(folder / "drive"), 4U);
}

TEST(PortLink, RefusesAFolder) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "drive");
  EXPECT_TRUE(contains(refusal(folder / "drive"), "a folder that virtdrive did not make is there"));
  EXPECT_TRUE(contains(refusal(folder / "drive/"), "it names a folder"));
  EXPECT_TRUE(fs::is_directory(folder / "drive"));
}

TEST(PortLink, RefusesALinkThatIsNotOursEvenToATerminal) {
  const TemporaryFolder folder;
  for (const char* target : {"/etc/hostname", "/dev/pts/7", "nowhere"}) {
    fs::create_symlink(target, folder / "drive");
    EXPECT_TRUE(contains(refusal(folder / "drive"), "a link that virtdrive did not make is there"));
    EXPECT_EQ(fs::read_symlink(folder / "drive"), target);
    fs::remove(folder / "drive");
    fs::remove(lock_of(folder / "drive"));
  }
}

TEST(PortLink, ARefusalLeavesNoLockBehind) {
  const TemporaryFolder folder;
  std::ofstream{folder / "drive"} << "mine";
  EXPECT_NE(refusal(folder / "drive"), "");
  EXPECT_FALSE(fs::exists(lock_of(folder / "drive")));
}

TEST(PortLink, RefusesALockFileThatIsNotOursAndLeavesIt) {
  const TemporaryFolder folder;
  std::ofstream{lock_of(folder / "drive")} << "precious\n";
  EXPECT_TRUE(contains(refusal(folder / "drive"), "is not a lock of virtdrive"));
  EXPECT_EQ(fs::file_size(lock_of(folder / "drive")), 9U);
  fs::remove(lock_of(folder / "drive"));
  std::ofstream{folder / "other"} << "precious\n";
  fs::create_symlink("other", lock_of(folder / "drive"));
  EXPECT_TRUE(contains(refusal(folder / "drive"), "cannot be opened"));
  EXPECT_EQ(fs::file_size(folder / "other"), 9U);
}

TEST(PortLink, NamesTheFolderThatIsNotThereAndTheRemedy) {
  const TemporaryFolder folder;
  const std::string text = refusal(folder / "no/drive");
  EXPECT_TRUE(contains(text, "there is no folder '" + (folder / "no").string() + "'")) << text;
  EXPECT_TRUE(contains(text, "mkdir -p")) << text;
  std::ofstream{folder / "file"} << "mine";
  EXPECT_TRUE(contains(refusal(folder / "file/drive"), "is not a folder"));
}

TEST(PortLink, NamesTheFolderThatIsNotWritable) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "closed");
  fs::permissions(folder / "closed", fs::perms{0555});
  fs::permissions(folder / "", fs::perms{0755});
  const uid_t user = geteuid();
  constexpr uid_t kNobody = 65534;
  ASSERT_TRUE(user != 0 || seteuid(kNobody) == 0);  // root may write everywhere
  const std::string text = refusal(folder / "closed/drive");
  ASSERT_TRUE(user != 0 || seteuid(user) == 0);
  EXPECT_TRUE(contains(text, "folder '" + (folder / "closed").string() + "' is not writable"))
      << text;
}

TEST(PortLink, RefusesANameThatARunningBenchHoldsAndSaysWhichProcess) {
  const TemporaryFolder folder;
  const fs::path path = folder / "drive";
  ChildProcess bench{[&](const std::function<void()>& ready) {
    const PortLink link{path, "/dev/pts/5"};
    ready();
    for (;;) pause();
    return 0;
  }};
  ASSERT_TRUE(bench.ready());
  const std::string text = refusal(path);
  EXPECT_TRUE(contains(text, fmt::format("a running bench has it (process {})", bench.pid())))
      << text;
  EXPECT_EQ(fs::read_symlink(path), "/dev/pts/5");
}

TEST(PortLink, RefusesANameThatThisProcessHolds) {
  const TemporaryFolder folder;
  const PortLink link{folder / "drive", "/dev/pts/5"};
  EXPECT_TRUE(contains(refusal(folder / "drive"), "a running bench has it"));
}

TEST(PortLink, TakesOverFromABenchThatWasKilled) {
  const TemporaryFolder folder;
  const fs::path path = folder / "drive";
  ChildProcess bench{[&](const std::function<void()>& ready) {
    const PortLink link{path, "/dev/pts/5"};
    ready();
    for (;;) pause();
    return 0;
  }};
  ASSERT_TRUE(bench.ready());
  bench.end(SIGKILL);
  EXPECT_EQ(fs::read_symlink(path), "/dev/pts/5");  // stale
  {
    const PortLink link{path, "/dev/pts/6"};
    EXPECT_EQ(fs::read_symlink(path), "/dev/pts/6");
  }
  EXPECT_FALSE(fs::is_symlink(path));
  EXPECT_FALSE(fs::exists(lock_of(path)));
}

TEST(PortLink, AfterAKillALinkThatSomebodyElsePutThereIsNotTakenOver) {
  const TemporaryFolder folder;
  std::ofstream{lock_of(folder / "drive")} << "virtdrive 99 /dev/pts/5\n";
  fs::create_symlink("/dev/pts/6", folder / "drive");
  EXPECT_NE(refusal(folder / "drive"), "");
  EXPECT_EQ(fs::read_symlink(folder / "drive"), "/dev/pts/6");
}

TEST(PortLink, RemovesOnlyWhatIsStillItsOwn) {
  const TemporaryFolder folder;
  const fs::path path = folder / "drive";
  {
    const PortLink link{path, "/dev/pts/5"};
    fs::remove(path);
    std::ofstream{path} << "mine";
  }
  EXPECT_TRUE(fs::is_regular_file(path));
  fs::remove(path);
  {
    const PortLink link{path, "/dev/pts/5"};
    fs::remove(path);
    fs::create_symlink("elsewhere", path);
    fs::remove(lock_of(path));
    std::ofstream{lock_of(path)} << "mine";
  }
  EXPECT_EQ(fs::read_symlink(path), "elsewhere");
  EXPECT_TRUE(fs::exists(lock_of(path)));
}

}  // namespace
}  // namespace virtdrive

// SPDX-License-Identifier: Apache-2.0
#include <sys/resource.h>

#include <csignal>
#include <cstdint>

#include "kernels/core/files.h"
#include "tests/support/test_files.h"

namespace vesta {
namespace {

std::ptrdiff_t NumFiles(const TempFolder& folder) {
  return std::distance(std::filesystem::directory_iterator(folder.path()), std::filesystem::directory_iterator());
}

TEST(AtomicFile, ReplacesTheOldFileOnlyOnCommit) {
  const TempFolder folder;
  const std::string path = folder / "out.bin";
  WriteFileAtomically(path, "old");
  {
    AtomicFile file(path);
    file.Write("ne");
    file.Write("w");
    EXPECT_EQ(ReadBytes(path), "old");
    file.Commit();
  }
  EXPECT_EQ(ReadBytes(path), "new");
  EXPECT_EQ(NumFiles(folder), 1);
}

TEST(AtomicFile, LeavesNothingWithoutCommit) {
  const TempFolder folder;
  { AtomicFile(folder / "out.bin").Write("half"); }
  EXPECT_EQ(NumFiles(folder), 0);
}

TEST(AtomicFile, RefusesFoldersItCannotWrite) {
  const TempFolder folder;
  EXPECT_THAT([&] { WriteFileAtomically(folder / "missing/out.bin", "x"); },
              ThrowsError(kCannotWrite, "missing/out.bin"));
  WriteBytes(folder / "file", "x");
  EXPECT_THAT([&] { WriteFileAtomically(folder / "file/out.bin", "x"); }, ThrowsError(kCannotWrite, "file/out.bin"));
  std::filesystem::create_directory(folder / "taken");
  EXPECT_THAT([&] { WriteFileAtomically(folder / "taken", "x"); }, ThrowsError(kCannotWrite, "taken"));
  EXPECT_EQ(NumFiles(folder), 2) << "no temporary file may remain";
}

// A file size limit simulates a full disk: write() fails after some bytes.
TEST(AtomicFile, ReportsAFullDiskAndKeepsTheOldFile) {
  const TempFolder folder;
  const std::string path = folder / "out.bin";
  WriteFileAtomically(path, "old");
  rlimit limit;
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &limit), 0);
  const rlim_t before = limit.rlim_cur;
  std::signal(SIGXFSZ, SIG_IGN);
  limit.rlim_cur = 1000;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
  const std::optional<Error> error = ErrorOf([&] { WriteFileAtomically(path, std::string(100000, 'x')); });
  limit.rlim_cur = before;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
  std::signal(SIGXFSZ, SIG_DFL);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code(), kCannotWrite);
  EXPECT_THAT(error->what(), HasTokens(path));
  EXPECT_EQ(ReadBytes(path), "old");
  EXPECT_EQ(NumFiles(folder), 1);
}

TEST(AtomicFile, KeepsReservedSpaceUntilItIsWritten) {
  const TempFolder folder;
  const std::string path = folder / "out.bin";
  AtomicFile file(path);
  file.Reserve(100000);
  const std::filesystem::directory_entry temporary = *std::filesystem::directory_iterator(folder.path());
  EXPECT_EQ(temporary.file_size(), 100000u);
  file.Reserve(10);
  EXPECT_EQ(std::filesystem::file_size(temporary.path()), 100000u);
  file.Write("short");
  file.Finish();
  EXPECT_FALSE(std::filesystem::exists(path));
  file.Commit();
  EXPECT_EQ(ReadBytes(path), "short");
}

TEST(AtomicFile, ReservesNothingIfTheDiskIsFull) {
  const TempFolder folder;
  AtomicFile file(folder / "out.bin");
  file.Reserve(1000);
  constexpr std::int64_t kMoreThanAnyDisk = std::int64_t{1} << 62;
  EXPECT_THAT([&] { file.Reserve(kMoreThanAnyDisk); }, ThrowsError(kCannotWrite, "out.bin"));
  EXPECT_EQ(std::filesystem::directory_iterator(folder.path())->file_size(), 1000u);
  file.Write("still of use");
  file.Commit();
  EXPECT_EQ(ReadBytes(folder / "out.bin"), "still of use");
}

TEST(AtomicFile, RemovesTemporariesThatNoProcessWrites) {
  const TempFolder folder;
  AtomicFile open(folder / "out.bin");
  for (const char* name : {"out.bin.1.tmp", "other.bin.1.tmp", "out.bin.tmp", "out.bin.x1.tmp", "out.bin.1.tmp.bak"}) {
    WriteBytes(folder / name, "half");
  }
  std::filesystem::create_directory(folder / "out.bin.2.tmp");
  ASSERT_EQ(NumFiles(folder), 7);
  RemoveAbandonedTemporaries(folder.path(), [](const std::string& name) { return name == "out.bin"; });
  EXPECT_EQ(NumFiles(folder), 6);
  EXPECT_FALSE(std::filesystem::exists(folder / "out.bin.1.tmp"));
  open.Write("whole");
  open.Commit();
  EXPECT_EQ(ReadBytes(folder / "out.bin"), "whole");
}

}  // namespace
}  // namespace vesta

#include "kernels/core/atomic_file.h"

#include <sys/resource.h>

#include <csignal>

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
  ExpectError([&] { WriteFileAtomically(folder / "missing/out.bin", "x"); }, "missing/out.bin: cannot be written");
  WriteBytes(folder / "file", "x");
  ExpectError([&] { WriteFileAtomically(folder / "file/out.bin", "x"); }, "choose a folder you can write");
  std::filesystem::create_directory(folder / "taken");
  ExpectError([&] { WriteFileAtomically(folder / "taken", "x"); }, "taken: cannot be written");
  EXPECT_EQ(NumFiles(folder), 2) << "no temporary may stay behind";
}

// A limit on the size of files stands in for a full disk: write() fails in the same way after some bytes.
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
  const std::string message = ErrorOf([&] { WriteFileAtomically(path, std::string(100000, 'x')); });
  limit.rlim_cur = before;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
  std::signal(SIGXFSZ, SIG_DFL);
  EXPECT_THAT(message, testing::HasSubstr("out.bin: cannot be written"));
  EXPECT_THAT(message, testing::HasSubstr("free some space"));
  EXPECT_EQ(ReadBytes(path), "old");
  EXPECT_EQ(NumFiles(folder), 1);
}

}  // namespace
}  // namespace vesta

// SPDX-License-Identifier: Apache-2.0
#include "apps/render/film.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include "apps/cli/child_process.h"
#include "apps/cli/outputs.h"
#include "kernels/core/check.h"
#include "splatting/io/images/image_codecs.h"

namespace vesta::app {
namespace {

std::string FindFfmpeg(const std::string& film) {
  std::string program = FindProgram("ffmpeg");
  if (program.empty()) {
    Fail(kUnavailable,
         "{}: the program ffmpeg is not installed; install it, or leave the flag out: the images are numbered frames",
         FlagText("film", film));
  }
  return program;
}

// Owns posix_spawn file actions.
class SpawnActions {
 public:
  SpawnActions() { posix_spawn_file_actions_init(&actions_); }
  ~SpawnActions() { posix_spawn_file_actions_destroy(&actions_); }
  SpawnActions(const SpawnActions&) = delete;
  SpawnActions& operator=(const SpawnActions&) = delete;
  posix_spawn_file_actions_t* get() { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_;
};

// Reads raw RGB from stdin. Writes Rec. 709 colours in yuv420p, which every player supports but which needs even sides.
std::vector<std::string> ArgumentsOf(const AtomicFile& file, gs::ImageSize size, double frames_per_second) {
  const std::string frame_size = fmt::format("{}x{}", size.width, size.height);
  return {"ffmpeg", "-hide_banner", "-loglevel", "error", "-nostdin", "-y",
          // Input.
          "-f", "rawvideo", "-pixel_format", "rgb24", "-video_size", frame_size, "-framerate",
          fmt::format("{}", frames_per_second), "-i", "pipe:0",
          // Output.
          "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv", "-pix_fmt", "yuv420p",
          "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709", "-color_range", "tv", "-movflags",
          "+faststart", "-f", "mp4", "file:" + file.temporary()};
}

// "/" becomes "_"; with_extension keeps ".jpg" before ".png".
std::string FileName(const gs::View& view, bool with_extension) {
  std::string name = view.name;
  if (!with_extension) name = std::filesystem::path(name).replace_extension().string();
  std::replace(name.begin(), name.end(), '/', '_');
  return name + ".png";
}

using Files = std::vector<std::string>;

// Adds all files, or returns false if one is already in the set.
bool AddAll(const Files& files, std::set<std::string>* taken) {
  if (std::ranges::any_of(files, [&](const std::string& file) { return taken->contains(file); })) return false;
  taken->insert(files.begin(), files.end());
  return true;
}

}  // namespace

void CheckFilm(const std::string& file) {
  if (!file.ends_with(".mp4")) Fail(kBadArgument, "{}: the name of a video must end in .mp4", FlagText("film", file));
  FindFfmpeg(file);
  CheckWritable("film", file);
}

Film::Film(const std::string& file, gs::ImageSize size, double frames_per_second)
    : file_(file), size_(size), output_(std::tmpfile(), std::fclose) {
  if (!output_) Fail(kCannotWrite, "{}: cannot create a temporary file; free some disk space", FlagText("film", file));
  Start(FindFfmpeg(file), frames_per_second);
}

Film::~Film() {
  if (process_ > 0) ::kill(process_, SIGTERM);
  Wait();
}

void Film::Start(const std::string& program, double frames_per_second) {
  std::vector<std::string> words = ArgumentsOf(file_, size_, frames_per_second);
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  // A socket instead of a pipe: if ffmpeg ends early, a write fails without SIGPIPE.
  std::array<int, 2> ends;
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    Fail(kCannotWrite, "{}: {}", FlagText("film", file_.path()), std::generic_category().message(errno));
  }
  SpawnActions actions;
  posix_spawn_file_actions_adddup2(actions.get(), ends[1], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(actions.get(), ::fileno(output_.get()), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(actions.get(), ::fileno(output_.get()), STDERR_FILENO);
  const int error = ::posix_spawn(&process_, program.c_str(), actions.get(), nullptr, arguments.data(), environ);
  ::close(ends[1]);
  frames_socket_ = ends[0];
  if (error != 0) {
    process_ = -1;
    Wait();
    Fail(kUnavailable, "{}: cannot run {}: {}", FlagText("film", file_.path()), program,
         std::generic_category().message(error));
  }
}

void Film::Add(const gs::Image& frame) {
  VESTA_CHECK(frame.width == size_.width && frame.height == size_.height,
              "{}: a frame has {} x {} pixels instead of {} x {}", file_.path(), frame.width, frame.height, size_.width,
              size_.height);
  const std::vector<std::uint8_t> bytes = gs::InterleavedBytes(frame);
  for (std::size_t sent = 0; sent < bytes.size();) {
    const ssize_t now = ::send(frames_socket_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (now < 0 && errno == EINTR) continue;
    if (now < 0) FailWithReason();
    sent += static_cast<std::size_t>(now);
  }
}

void Film::Finish() {
  if (Wait() != 0) FailWithReason();
  file_.Commit();
}

int Film::Wait() {
  if (frames_socket_ >= 0) ::close(std::exchange(frames_socket_, -1));
  int status = 0;
  const pid_t process = std::exchange(process_, -1);
  while (process > 0 && ::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

void Film::FailWithReason() {
  Wait();
  std::array<char, 512> line{};
  std::rewind(output_.get());
  if (!std::fgets(line.data(), line.size(), output_.get())) line = {"it ended without a message"};
  std::string reason = line.data();
  if (reason.ends_with('\n')) reason.pop_back();
  Fail(kCannotWrite, "{}: ffmpeg failed: {}", FlagText("film", file_.path()), reason);
}

std::vector<std::string> FileNames(const std::vector<const gs::View*>& views,
                                   const std::function<Files(const std::string&)>& files_of) {
  std::vector<std::string> names;
  for (const bool with_extension : {false, true}) {
    names.clear();
    std::set<std::string> taken;
    bool are_different = true;
    for (const gs::View* view : views) {
      names.push_back(FileName(*view, with_extension));
      are_different = AddAll(files_of(names.back()), &taken) && are_different;
    }
    if (are_different) return names;
  }
  std::set<std::string> wanted, seen;  // of all names; of the names so far
  for (const std::string& name : names) {
    for (std::string& file : files_of(name)) wanted.insert(std::move(file));
  }
  for (std::string& name : names) {
    if (AddAll(files_of(name), &seen)) continue;
    const std::string stem = name.substr(0, name.rfind('.'));
    for (int number = 2;; ++number) {
      name = fmt::format("{}_{}.png", stem, number);
      if (AddAll(files_of(name), &wanted)) break;
    }
  }
  return names;
}

}  // namespace vesta::app

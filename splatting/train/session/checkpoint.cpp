// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/session/checkpoint.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string_view>

#include "kernels/core/check.h"
#include "kernels/core/files.h"

namespace vesta::gs {
namespace {

// File format: these eight bytes, the version, RunState, the state of the stage, and the CRC-32 of all.
constexpr std::string_view kMagic = "vestaTRN";
// Increase when a Visit function of the saved state changes.
constexpr std::uint32_t kVersion = 15;

std::uint32_t Checksum(std::uint32_t before, std::string_view bytes) {
  if (bytes.empty()) return before;  // for a null pointer zlib returns the initial checksum
  return static_cast<std::uint32_t>(
      ::crc32_z(before, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

template <class T>
std::string_view BytesOf(const T& value) {
  return {reinterpret_cast<const char*>(&value), sizeof(value)};
}

// A valid checksum does not prove that vesta wrote the values.
bool IsPossible(const RunState& run) {
  const auto is_stage = [](Stage stage) { return stage == Stage::kAdam || stage == Stage::kLm; };
  const auto is_time = [](double seconds) { return std::isfinite(seconds) && seconds >= 0; };
  return is_stage(run.stage) && run.iteration >= 0 && is_time(run.seconds) && is_time(run.eval_seconds) &&
         std::all_of(run.history.begin(), run.history.end(),
                     [&](const HistoryRow& row) { return is_stage(row.stage); });
}

}  // namespace

std::uint64_t FingerprintOf(const Scene& scene) {
  // FNV-1a, 64 bits.
  std::uint64_t hash = 14695981039346656037u;
  ArchiveWriter writer([&](std::string_view bytes) {
    for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * 1099511628211u;
  });
  for (const View& view : scene.views) {
    std::string name = view.name;
    Camera camera = view.camera;
    ViewRole role = view.role;
    auto rotation = view.rotation;
    auto translation = view.translation;
    writer(name, camera.width, camera.height, camera.lens, camera.eps2d, camera.antialiased, role, rotation,
           translation);
    if (!view.bent) continue;
    LensCamera bent = *view.bent;
    Distortion& of_lens = bent.distortion;
    writer(bent.camera.width, bent.camera.height, bent.camera.lens, of_lens.is_fisheye, of_lens.radial,
           of_lens.tangential);
  }
  return hash;
}

void WriteCheckpoint(const std::string& path, RunState& run, const std::function<void(ArchiveWriter&)>& stage_state) {
  AtomicFile file(path);
  std::uint32_t checksum = 0;
  const auto write = [&](std::string_view bytes) {
    checksum = Checksum(checksum, bytes);
    file.Write(bytes);
  };
  write(kMagic);
  write(BytesOf(kVersion));
  ArchiveWriter archive(write);
  archive(run);
  stage_state(archive);
  file.Write(BytesOf(checksum));
  file.Commit();
}

bool IsCheckpoint(const std::string& path) {
  std::string begin(kMagic.size(), '\0');
  std::ifstream file(path, std::ios::binary);
  return file.read(begin.data(), static_cast<std::streamsize>(begin.size())) && begin == kMagic;
}

Checkpoint ReadCheckpoint(const std::string& path) {
  const std::string bytes = ReadFile(path);
  std::string_view rest = bytes;
  if (!rest.starts_with(kMagic)) Fail(kBadFile, "{}: not a checkpoint of vesta", path);
  rest.remove_prefix(kMagic.size());
  std::uint32_t version = 0, checksum = 0;
  const auto damaged = [&] {
    Fail(kBadFile, "{}: truncated or damaged; resume from another checkpoint, or start a new training", path);
  };
  if (rest.size() < sizeof(version) + sizeof(checksum)) damaged();
  std::memcpy(&version, rest.data(), sizeof(version));
  std::memcpy(&checksum, bytes.data() + bytes.size() - sizeof(checksum), sizeof(checksum));
  if (checksum != Checksum(0, std::string_view(bytes).substr(0, bytes.size() - sizeof(checksum)))) damaged();
  if (version != kVersion) {
    Fail(kUnsupported,
         "{}: checkpoint version {}, but this program reads version {}; resume with the program that wrote it", path,
         version, kVersion);
  }
  rest.remove_prefix(sizeof(version));
  rest.remove_suffix(sizeof(checksum));
  Checkpoint checkpoint{.path = path, .run = {}, .stage_state = {}};
  try {
    ArchiveReader reader(rest);
    reader(checkpoint.run);
    checkpoint.stage_state = reader.rest();
  } catch (const Error&) {
    damaged();
  }
  if (!IsPossible(checkpoint.run)) damaged();
  return checkpoint;
}

}  // namespace vesta::gs

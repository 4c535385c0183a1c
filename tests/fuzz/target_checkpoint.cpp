// SPDX-License-Identifier: Apache-2.0
#include <zlib.h>

#include <cstdint>

#include "apps/training/checkpointing.h"
#include "splatting/train/lm_stage/lm_solve.h"
#include "splatting/train/session/checkpoint.h"
#include "tests/fuzz/options_promise.h"
#include "tests/fuzz/promise.h"
#include "tests/fuzz/scratch_folder.h"
#include "tests/fuzz/targets.h"

namespace vesta::fuzz {
namespace {

// The beginning of every checkpoint of this version.
std::string Beginning(const ScratchFolder& folder) {
  constexpr std::size_t kMagicAndVersion = 12;
  gs::RunState run;
  gs::WriteCheckpoint(folder / "empty", run, [](ArchiveWriter&) {});
  return folder.Read("empty").substr(0, kMagicAndVersion);
}

}  // namespace

bool ReadsCheckpoint(std::string_view bytes) {
  static const ScratchFolder folder;
  static const std::string beginning = Beginning(folder);
  std::string file = beginning + std::string(bytes);
  const auto checksum =
      static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const unsigned char*>(file.data()), file.size()));
  file.append(reinterpret_cast<const char*>(&checksum), sizeof(checksum));
  const std::string path = folder.Write("checkpoint.vesta", file);
  gs::Checkpoint checkpoint;
  if (!Reads(path, [&] { checkpoint = gs::ReadCheckpoint(path); })) return false;
  const gs::Stage stage = checkpoint.run.stage;
  Promise(stage == gs::Stage::kAdam || stage == gs::Stage::kLm, "an unknown stage");
  Promise(checkpoint.iteration() >= 0, "iterations below zero");
  app::Origin origin;
  const bool has_origin = Reads(path, [&] { origin = app::ReadOrigin(checkpoint); });
  if (has_origin) PromiseOptions(origin.settings.options);
  if (stage != gs::Stage::kLm) return has_origin;
  gs::SplatModel model;
  if (!Reads("", [&] { model = gs::ModelOfLmStage(checkpoint.stage_state); })) return false;
  Promise(model.sh_degree >= 0 && model.sh_degree <= 3 && static_cast<Index>(model.data.size()) == model.Size(),
          "a model with a wrong number of values");
  return has_origin;
}

void FuzzCheckpoint(std::string_view bytes) { ReadsCheckpoint(bytes); }

}  // namespace vesta::fuzz

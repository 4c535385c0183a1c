// SPDX-License-Identifier: Apache-2.0
// convert: writes a splat in another format, optionally filtered.
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/cli/outputs.h"
#include "apps/cli/print.h"
#include "apps/commands/commands.h"
#include "apps/inputs/scene_and_splat.h"
#include "apps/inputs/splat_filters.h"
#include "splatting/io/splats/splat_file.h"

namespace vesta::app {
namespace {

double MegabytesOf(const std::string& file) { return 1e-6 * static_cast<double>(std::filesystem::file_size(file)); }

}  // namespace

int RunConvert(const CommandLine& line) {
  const std::string &from = line.arguments[0], &to = line.flags.out;
  CheckFilterFlags(line.flags);
  RunFiles files = FilesOf(line);
  if (!line.flags.scene.empty()) files.ReadsScene(line.flags.scene);
  files.Writes(FlagText("out", to), to);
  files.Check();
  gs::CheckSplatExtension(to);
  CheckWritable("out", to);
  std::string message;
  const gs::SplatModel model = Filtered(line.flags, LoadSplat(from), &files, &message);
  std::vector<std::string> notes;
  gs::WriteSplat(to, model, {.spz_version = static_cast<std::uint32_t>(line.flags.spz_version), .notes = &notes});
  for (const std::string& note : notes) Print("{}\n", note);
  Print("{}", message);
  Print("{} Gaussians of SH degree {}: {:.3f} MB, now {:.3f} MB in {}\n", model.count, model.sh_degree,
        MegabytesOf(from), MegabytesOf(to), to);
  return 0;
}

}  // namespace vesta::app

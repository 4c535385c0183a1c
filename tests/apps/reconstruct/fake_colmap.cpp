// SPDX-License-Identifier: Apache-2.0
#include "tests/apps/reconstruct/fake_colmap.h"

#include <fmt/format.h>

#include <filesystem>
#include <sstream>

#include "splatting/io/scenes/colmap.h"

namespace vesta::test {
namespace {

namespace fs = std::filesystem;

// "END" ends a call. The list of names is printed as an option "names" whose value has a slash per line end.
constexpr const char* kScript = R"sh(
cd '{0}'
case "$1" in help) echo 'COLMAP 3.8 (Commit 1 on 2023-01-01 without CUDA)'; exit 0 ;; esac
case "$2" in
  -h)
    for name in ImageReader.single_camera ImageReader.camera_model Mapper.num_threads \
      ExhaustiveMatching.block_size SequentialMatching.overlap SequentialMatching.loop_detection \
      {1}Extraction.use_gpu {1}Extraction.num_threads {1}Extraction.max_image_size {1}Matching.use_gpu \
      {1}Matching.num_threads_of_more {1}Matching.num_threads; do
      echo "  --$name arg (=1)"
    done
    exit 0 ;;
esac
{{
  echo "$1"
  command=$1
  shift
  while [ $# -gt 0 ]; do
    printf '%s\n%s\n' "$1" "$2"
    [ "$1" != --image_list_path ] || printf 'names\n%s\n' "$(tr '\n' '/' <"$2")"
    [ "$1" != --output_path ] || output=$2
    shift 2
  done
  echo END
}} >>calls
echo "messages of $command"
[ ! -e "when_$command" ] || . "./when_$command"
[ "$command" != mapper ] || cp -r models/. "$output"
)sh";

}  // namespace

FakeColmap::FakeColmap(const std::string& folder, bool is_new) : folder_(folder), path_(folder + "/bin:/usr/bin:/bin") {
  fs::create_directories(folder_ + "/models");
  WriteScript(programs() + "/colmap", fmt::format(kScript, folder_, is_new ? "Feature" : "Sift"));
}

void FakeColmap::AddModel(int number, std::size_t images) const {
  gs::ColmapModel model = TinyModel();
  model.images.resize(images);
  gs::WriteColmapModel(model, fmt::format("{}/models/{}", folder_, number), gs::ColmapFormat::kBinary);
}

void FakeColmap::When(const std::string& command, const std::string& commands) const {
  WriteBytes(folder_ + "/when_" + command, commands + "\n");
}

std::vector<ColmapCall> FakeColmap::TakeCalls() const {
  std::vector<ColmapCall> calls;
  std::istringstream lines(ReadBytes(folder_ + "/calls"));
  for (std::string line; std::getline(lines, line);) {
    ColmapCall& call = calls.emplace_back();
    call.command = line;
    for (std::string name, value; std::getline(lines, name) && name != "END";) {
      std::getline(lines, value);
      (name == "names" ? call.names : call.options[name.substr(2)]) = value;
    }
  }
  fs::remove(folder_ + "/calls");
  return calls;
}

std::vector<std::string> FakeColmap::TakeCommands() const {
  std::vector<std::string> commands;
  for (const ColmapCall& call : TakeCalls()) commands.push_back(call.command);
  return commands;
}

}  // namespace vesta::test

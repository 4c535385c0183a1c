// SPDX-License-Identifier: Apache-2.0
// Writes the binary seeds with the writers of the library and of its tests:
//   fuzz_seeds tests/fuzz/corpus
#include <png.h>
#include <tiff.h>

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/training/checkpointing.h"
#include "splatting/io/bytes/bytes.h"
#include "splatting/io/bytes/zip.h"
#include "splatting/io/images/image_file.h"
#include "splatting/io/splats/compressed_ply.h"
#include "splatting/io/splats/ply.h"
#include "splatting/io/splats/sog.h"
#include "splatting/io/splats/splat_file.h"
#include "splatting/io/splats/spz.h"
#include "splatting/train/lm_stage/lm_solve.h"
#include "splatting/train/session/checkpoint.h"
#include "tests/fuzz/scratch_folder.h"
#include "tests/fuzz/seed_model.h"
#include "tests/splatting/io/ksplat_parts.h"
#include "tests/splatting/io/test_images.h"

namespace vesta::fuzz {
namespace {

void WriteSeed(const std::string& path, const std::string& bytes) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
}

void ColmapSeeds(const ScratchFolder& scratch, const std::string& corpus) {
  gs::WriteColmapModel(SeedModel(), scratch / "model", gs::ColmapFormat::kBinary);
  gs::WriteColmapModel(SeedModel(), scratch / "model", gs::ColmapFormat::kText);
  int choice = 0;
  for (const char* end : {"bin", "txt"}) {
    for (const char* name : {"cameras", "images", "points3D"}) {
      const std::string file = std::string(name) + "." + end;
      WriteSeed(corpus + "/colmap/" + file, std::to_string(choice++) + scratch.Read("model/" + file));
    }
  }
}

// Decompresses gzip data.
std::string Unzipped(const std::string& zipped) {
  gs::GzipReader reader("seed", zipped);
  std::string bytes(1 << 16, '\0');
  bytes.resize(reader.Read(bytes.data(), bytes.size()));
  return bytes;
}

// The files of a .sog in the form of its target. Codebooks are cut to the numbers that are used.
std::string SogParts(const std::string& bundle) {
  const gs::ZipReader reader("seed", bundle);
  nlohmann::json meta = nlohmann::json::parse(reader.Read("meta.json"));
  std::string images;
  int number = 0;
  for (const char* property : {"means", "quats", "scales", "sh0", "shN"}) {
    if (!meta.contains(property)) continue;
    for (nlohmann::json& file : meta[property]["files"]) {
      images += reader.Read(file.get<std::string>());
      file = std::to_string(number++);
    }
    if (meta[property].contains("codebook")) {
      nlohmann::json& codebook = meta[property]["codebook"];
      while (codebook.size() > 1 && codebook.back() == codebook[codebook.size() - 2])
        codebook.erase(codebook.size() - 1);
    }
  }
  return meta.dump() + "\n" + images;
}

void SplatSeeds(const ScratchFolder& scratch, const std::string& corpus) {
  for (const char* folder : {"/splat_ply", "/compressed_ply"}) std::filesystem::create_directories(corpus + folder);
  for (int degree = 0; degree <= 3; ++degree) {
    gs::SplatModel model;
    model.Resize(degree, 2);
    for (std::size_t i = 0; i < model.data.size(); ++i) model.data[i] = 0.25f * static_cast<float>(i % 7) - 0.5f;
    for (Index i = 0; i < model.count; ++i) model.attribute(splat::kQuaternion)[i] = 1;
    model.has_background = degree == 1;
    if (degree == 2) model.origin = {1, 2, 3};
    if (degree == 3) model.eps2d = 0.1, model.antialiased = true;
    const std::string name = "degree" + std::to_string(degree);
    gs::WriteSplatPly(corpus + "/splat_ply/" + name + ".ply", model);
    gs::WriteCompressedPly(corpus + "/compressed_ply/" + name + ".ply", model);
    gs::WriteSog(scratch / "seed.sog", model);
    const std::string bundle = scratch.Read("seed.sog");
    WriteSeed(corpus + "/sog/" + name, SogParts(bundle));
    if (degree == 0) WriteSeed(corpus + "/sog/bundle.sog", bundle);
    gs::WriteSpz(scratch / "seed.spz", model);
    WriteSeed(corpus + "/spz_streams/" + name, scratch.Read("seed.spz"));
    gs::WriteSpz(scratch / "seed.spz", model, gs::kUniversalSpz);
    const std::string zipped = scratch.Read("seed.spz");
    const std::string comment = degree == 2 ? "vesta origin 1 2 3\n" : "";
    std::string bytes = Unzipped(zipped);
    WriteSeed(corpus + "/spz/" + name, comment + bytes);
    if (degree == 1) WriteSeed(corpus + "/spz/zipped.spz", zipped);
    if (degree > 0) continue;
    gs::WriteSplat(scratch / "seed.splat", model);
    WriteSeed(corpus + "/antimatter_splat/two", scratch.Read("seed.splat"));
    // Version 3 has one more byte per rotation (stored last), and version 1 three fewer per mean.
    bytes[4] = 3;
    WriteSeed(corpus + "/spz/version3", bytes + "\x80\xc0");
    bytes[4] = 1;
    WriteSeed(corpus + "/spz/version1", bytes.erase(16, 6));
  }
}

// Without the unused bytes of the headers, which the target adds.
void KsplatSeeds(const std::string& corpus) {
  for (int level = 0; level <= 2; ++level) {
    gs::KsplatParts parts;
    parts.level = level;
    parts.sections = {{}, {}};
    parts.num_sections = 2;
    parts.count = 4;
    parts.sections[1].degree = static_cast<std::uint16_t>(level);
    const std::string file = parts.File();
    std::string seed = file.substr(0, gs::kKsplatHeaderUsed);
    for (std::size_t at = gs::kKsplatHeader, end = at + 2 * gs::kKsplatSectionHeader; at < end;
         at += gs::kKsplatSectionHeader) {
      seed += file.substr(at, gs::kKsplatSectionUsed);
    }
    WriteSeed(corpus + "/ksplat/level" + std::to_string(level),
              seed + file.substr(gs::kKsplatHeader + 2 * gs::kKsplatSectionHeader));
  }
}

void ImageSeeds(const std::string& corpus) {
  const auto bytes = [](std::size_t size) {
    std::vector<std::uint8_t> values(size);
    for (std::size_t i = 0; i < size; ++i) values[i] = static_cast<std::uint8_t>(37 * i);
    return values;
  };
  const std::string folder = corpus + "/image/";
  WriteSeed(folder + "rgb.jpg", gs::EncodeJpeg({5, 4, 3, false, bytes(60)}));
  WriteSeed(folder + "grey.jpg", gs::EncodeJpeg({5, 4, 1, false, bytes(20)}));
  WriteSeed(folder + "progressive.jpg", gs::EncodeJpeg({9, 10, 3, true, bytes(270)}));
  WriteSeed(folder + "cmyk.jpg", gs::EncodeJpeg({2, 2, 4, false, bytes(16)}));
  WriteSeed(folder + "rgb.png", gs::EncodePng({5, 4, PNG_COLOR_TYPE_RGB, 8, false, bytes(60)}));
  WriteSeed(folder + "rgba16.png", gs::EncodePng({3, 2, PNG_COLOR_TYPE_RGB_ALPHA, 16, false, bytes(48)}));
  WriteSeed(folder + "interlaced.png", gs::EncodePng({9, 9, PNG_COLOR_TYPE_GRAY, 8, true, bytes(81)}));
  WriteSeed(folder + "palette.png", gs::EncodePng({4, 2, PNG_COLOR_TYPE_PALETTE, 2, false, {0x18, 0x81}}));
  WriteSeed(folder + "rgb.webp", gs::EncodeWebp(5, 4, 3, bytes(60)));
  WriteSeed(folder + "rgba.webp", gs::EncodeWebp(3, 2, 4, bytes(24)));
  gs::TiffSource tiff{.width = 5, .height = 4, .bytes = bytes(160)};
  WriteSeed(folder + "rgb.tif", gs::EncodeTiff(tiff));
  tiff.compression = COMPRESSION_LZW, tiff.separate_planes = true;
  WriteSeed(folder + "planes.tif", gs::EncodeTiff(tiff));
  tiff.samples = 4, tiff.bits = 16, tiff.extra_kind = EXTRASAMPLE_ASSOCALPHA;
  tiff.compression = COMPRESSION_ADOBE_DEFLATE, tiff.separate_planes = false, tiff.tile = 16;
  WriteSeed(folder + "tile.tif", gs::EncodeTiff(tiff));
}

// Without magic number, version and checksum, which the target adds.
void CheckpointSeeds(const ScratchFolder& scratch, const std::string& corpus) {
  constexpr std::size_t kMagicAndVersion = 12, kChecksum = 4;
  for (const gs::Stage stage : {gs::Stage::kAdam, gs::Stage::kLm}) {
    gs::RunState run;
    run.origin = R"({"scene": "s", "checkpoint_every": "5", "snapshot_every": "", "preset": "fast",)"
                 R"( "options": {"adam": {"iterations": 7}}})";
    run.stage = stage;
    run.iteration = 3;
    run.history = {
        {.stage = stage, .iteration = 2, .seconds = 1, .cost = 0.5, .train = {}, .test = {}, .gaussians = 2}};
    run.notes = {"a note"};
    gs::LmStageHeader header{.layout = {.count = 2}, .done = 1, .units = {1, 1}};
    std::vector<float> parameters(2 * splat::NumAttributes(0), 0.5f);
    gs::WriteCheckpoint(scratch / "checkpoint", run, [&](ArchiveWriter& archive) { archive(header, parameters); });
    const std::string bytes = scratch.Read("checkpoint");
    WriteSeed(corpus + "/checkpoint/" + (stage == gs::Stage::kAdam ? "adam" : "lm"),
              bytes.substr(kMagicAndVersion, bytes.size() - kMagicAndVersion - kChecksum));
  }
}

// Any bytes are a scene. The seeds are short and of different lengths.
void OperatorSeeds(const std::string& corpus) {
  unsigned state = 1;
  for (const std::size_t size : {40u, 200u, 700u, 1500u}) {
    std::string bytes;
    for (std::size_t i = 0; i < size; ++i) {
      state = 1664525u * state + 1013904223u;
      bytes += static_cast<char>(state >> 24);
    }
    for (const char wild : {0, 1}) {
      bytes[0] = wild, bytes[1] = 3;
      WriteSeed(corpus + "/operators/" + (wild ? "wild" : "tame") + std::to_string(size), bytes);
    }
  }
}

}  // namespace
}  // namespace vesta::fuzz

int main(int argc, char** argv) {
  if (argc != 2) return std::fputs("usage: fuzz_seeds CORPUS\n", stderr), 2;
  const vesta::fuzz::ScratchFolder scratch;
  vesta::fuzz::ColmapSeeds(scratch, argv[1]);
  vesta::fuzz::SplatSeeds(scratch, argv[1]);
  vesta::fuzz::KsplatSeeds(argv[1]);
  vesta::fuzz::ImageSeeds(argv[1]);
  vesta::fuzz::CheckpointSeeds(scratch, argv[1]);
  vesta::fuzz::OperatorSeeds(argv[1]);
}

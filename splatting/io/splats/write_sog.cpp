// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <deque>
#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/parallel.h"
#include "splatting/io/bytes/zip.h"
#include "splatting/io/images/image_codecs.h"
#include "splatting/io/splats/compressed_ply.h"
#include "splatting/io/splats/packed_values.h"
#include "splatting/io/splats/palette.h"
#include "splatting/io/splats/sog.h"

namespace vesta::gs {
namespace {

using nlohmann::json;

// An image of four samples per pixel; at first opaque black.
class Canvas {
 public:
  Canvas(Index width, Index height) {
    image_.size = {static_cast<int>(width), static_cast<int>(height)};
    image_.samples = 4;
    image_.Allocate();
    for (std::size_t i = 3; i < image_.bytes.size(); i += 4) image_.bytes[i] = 255;
  }
  std::uint8_t* at(Index pixel) { return image_.bytes.data() + 4 * pixel; }
  const InterleavedImage& image() const { return image_; }

 private:
  InterleavedImage image_;
};

// The shortest decimals that give the same floats again.
std::vector<double> ShortDecimals(const NumberPalette& palette) {
  std::vector<double> numbers(palette.size());
  for (std::size_t i = 0; i < palette.size(); ++i) ParseNumber(fmt::format("{}", palette[i]), &numbers[i]);
  return numbers;
}

void SetLabel(Index label, std::uint8_t* low, std::uint8_t* high) {
  *low = static_cast<std::uint8_t>(label & 0xff);
  *high = static_cast<std::uint8_t>(label >> 8);
}

// Writes the images of a model, and collects their description.
class SogWriter {
 public:
  SogWriter(const std::string& path, const SplatModel& model) : path_(path), model_(model) {
    // Multiples of four pixels, as in splat-transform.
    width_ = static_cast<Index>(std::ceil(std::sqrt(static_cast<double>(model.count)) / 4)) * 4;
    height_ = ((model.count - 1) / (4 * width_) + 1) * 4;
    constexpr Index kMostSide = 16383;  // of WebP
    if (std::max(width_, height_) > kMostSide) {
      Fail(kBadArgument, "{}: {} Gaussians are too many for the images of .sog; write a .ply", path, model.count);
    }
    // Spatially close Gaussians are close in the images, which compress better then.
    constexpr Index kPixelChunk = 256;
    order_ = ChunkOrder(model, kPixelChunk);
    meta_ = {{"version", sog::kVersion}, {"asset", {{"generator", "vesta"}}}, {"count", model.count}};
    if (model.antialiased) meta_["antialias"] = true, meta_["model"] = sog::kAntialiased;
    const std::vector<std::string> comments = SplatComments(model);
    if (!comments.empty()) meta_["extras"] = {{"vesta", comments}};
  }

  std::string Bundle() {
    WriteMeans();
    WriteRotations();
    WriteScales();
    WriteColors();
    if (model_.sh_degree > 0) WriteHigherHarmonics();
    std::vector<ZipEntry> entries(canvases_.size() + 1);
    ParallelFor(static_cast<Index>(canvases_.size()), 1, [&](Index i) {
      const auto& [name, canvas] = canvases_[static_cast<std::size_t>(i)];
      entries[static_cast<std::size_t>(i)] = {name, EncodeLosslessWebp(path_, canvas.image())};
    });
    entries.back() = {sog::kMetaFile, meta_.dump()};
    return Zip(entries);
  }

 private:
  Canvas* AddCanvas(const char* property, const std::string& name, Index width, Index height) {
    meta_[property]["files"].push_back(name);
    return &canvases_.emplace_back(name, Canvas(width, height)).second;
  }
  Canvas* AddCanvas(const char* property, const std::string& name) {
    return AddCanvas(property, name, width_, height_);
  }
  // Calls set(pixel, Gaussian) for all Gaussians.
  void ForGaussians(const std::function<void(Index pixel, Index gaussian)>& set) const {
    ParallelFor(model_.count, 1024, [&](Index pixel) { set(pixel, order_[static_cast<std::size_t>(pixel)]); });
  }
  double Value(int attribute, Index gaussian) const { return static_cast<double>(model_.Value(attribute, gaussian)); }

  void WriteMeans() {
    Canvas *lower = AddCanvas("means", "means_l.webp"), *upper = AddCanvas("means", "means_u.webp");
    for (int k = 0; k < 3; ++k) {
      const float* mean = model_.attribute(splat::kMean + k);
      const auto [least, greatest] = std::minmax_element(mean, mean + model_.count);
      const double low = sog::LogOfMean(static_cast<double>(*least)),
                   high = sog::LogOfMean(static_cast<double>(*greatest));
      meta_["means"]["mins"].push_back(low);
      meta_["means"]["maxs"].push_back(high);
      const double scale = high > low ? sog::kMeanSteps / (high - low) : 0;
      ForGaussians([&](Index pixel, Index i) {
        const double steps = std::round((sog::LogOfMean(static_cast<double>(mean[i])) - low) * scale);
        SetLabel(static_cast<Index>(std::clamp(steps, 0.0, sog::kMeanSteps)), lower->at(pixel) + k,
                 upper->at(pixel) + k);
      });
    }
  }

  void WriteRotations() {
    Canvas* canvas = AddCanvas("quats", "quats.webp");
    ForGaussians([&](Index pixel, Index i) {
      constexpr int q = splat::kQuaternion;
      const SmallestThree three = ToSmallestThree({Value(q, i), Value(q + 1, i), Value(q + 2, i), Value(q + 3, i)});
      for (std::size_t k = 0; k < 3; ++k) {
        const double byte = std::round((three.rest[k] / kLargestOfSmallest + 1) * sog::kRotationScale);
        canvas->at(pixel)[k] = static_cast<std::uint8_t>(std::clamp(byte, 0.0, 255.0));
      }
      canvas->at(pixel)[3] = static_cast<std::uint8_t>(sog::kFirstTag + three.largest);
    });
  }

  // Three attributes with a common palette.
  Canvas* WriteWithPalette(const char* property, const std::string& name, int first_attribute) {
    const float* values = model_.attribute(first_attribute);
    const NumberPalette palette = MakeNumberPalette({values, values + 3 * model_.count});
    meta_[property]["codebook"] = ShortDecimals(palette);
    Canvas* canvas = AddCanvas(property, name);
    ForGaussians([&](Index pixel, Index i) {
      for (int k = 0; k < 3; ++k) {
        canvas->at(pixel)[k] = NearestEntry(palette, model_.attribute(first_attribute + k)[i]);
      }
    });
    return canvas;
  }
  void WriteScales() { WriteWithPalette("scales", "scales.webp", splat::kLogScale); }

  void WriteColors() {
    Canvas* canvas = WriteWithPalette("sh0", "sh0.webp", splat::kSh);
    ForGaussians(
        [&](Index pixel, Index i) { canvas->at(pixel)[3] = OpacityByte(model_.attribute(splat::kOpacity)[i]); });
  }

  void WriteHigherHarmonics() {
    const Index rest = sog::HigherCoefficients(model_.sh_degree), dimension = 3 * rest;
    std::vector<float> vectors(static_cast<std::size_t>(model_.count * dimension));
    ForGaussians([&](Index pixel, Index i) {
      for (Index k = 0; k < dimension; ++k) {
        vectors[static_cast<std::size_t>(pixel * dimension + k)] =
            model_.Value(splat::kSh + 3 + static_cast<int>(k), i);
      }
    });
    const auto count =
        std::min(static_cast<Index>(std::bit_floor(static_cast<std::uint64_t>(model_.count))), sog::kMostEntries);
    const VectorPalette palette = MakeVectorPalette(vectors, dimension, count);
    const NumberPalette numbers = MakeNumberPalette(palette.entries);
    meta_["shN"] = {{"count", count}, {"bands", model_.sh_degree}, {"codebook", ShortDecimals(numbers)}};

    Canvas* entries =
        AddCanvas("shN", "shN_centroids.webp", sog::kEntriesPerRow * rest, (count - 1) / sog::kEntriesPerRow + 1);
    ParallelFor(count * rest, 1024, [&](Index pixel) {
      for (Index c = 0; c < 3; ++c) {
        entries->at(pixel)[c] = NearestEntry(numbers, palette.entries[static_cast<std::size_t>(3 * pixel + c)]);
      }
    });
    Canvas* labels = AddCanvas("shN", "shN_labels.webp");
    for (Index pixel = 0; pixel < model_.count; ++pixel) {
      std::uint8_t* out = labels->at(pixel);
      SetLabel(palette.labels[static_cast<std::size_t>(pixel)], out, out + 1);
    }
  }

  const std::string& path_;
  const SplatModel& model_;
  std::vector<Index> order_;  // Gaussian per pixel
  Index width_ = 0, height_ = 0;
  json meta_;
  std::deque<std::pair<std::string, Canvas>> canvases_;
};

}  // namespace

void WriteSog(const std::string& path, const SplatModel& model) {
  CheckDrawable(path, model);
  if (model.count == 0) Fail(kBadArgument, "{}: cannot write a splat without Gaussians", path);
  WriteFileAtomically(path, SogWriter(path, model).Bundle());
}

}  // namespace vesta::gs

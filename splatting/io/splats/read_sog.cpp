// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/parallel.h"
#include "kernels/math/spherical_harmonics.h"
#include "splatting/io/bytes/zip.h"
#include "splatting/io/images/image_codecs.h"
#include "splatting/io/splats/packed_values.h"
#include "splatting/io/splats/palette.h"
#include "splatting/io/splats/sog.h"

namespace vesta::gs {
namespace {

using nlohmann::json;

bool IsZip(std::string_view bytes) { return bytes.starts_with("PK"); }

// The files of a splat.
class SogFiles {
 public:
  SogFiles(const std::string& path, std::string_view bytes) : path_(path) {
    if (IsZip(bytes)) zip_ = std::make_unique<ZipReader>(path, bytes);
    meta_ = json::parse(zip_ ? zip_->Read(sog::kMetaFile) : std::string(bytes), nullptr, false);
    if (!meta_.is_object()) FailMeta("it is not a JSON object");
    const auto version = meta_.find("version");
    if (version == meta_.end() && !meta_.contains("means")) {
      Fail(kBadFile, "{}: a JSON file, but not the {} of a .sog: it has no means", path_, sog::kMetaFile);
    }
    if (version == meta_.end() || *version != sog::kVersion) {
      Fail(kUnsupported, "{}: only version {} of .sog is supported; convert the file with splat-transform", path_,
           sog::kVersion);
    }
  }

  const json& meta() const { return meta_; }

  [[noreturn]] void FailMeta(const std::string& problem) const {
    Fail(kBadFile, "{}: {} is damaged: {}; export the splat again", path_, sog::kMetaFile, problem);
  }

  const json& Member(const json& object, const char* key) const {
    if (!object.is_object() || !object.contains(key)) FailMeta(fmt::format("{} is missing", key));
    return object[key];
  }

  Index Count(const json& object, const char* key, Index most) const {
    const json& value = Member(object, key);
    if (!value.is_number_integer() || value < 1 || value > most) {
      FailMeta(fmt::format("{} is not a whole number in 1..{}", key, most));
    }
    return value.get<Index>();
  }

  std::array<double, 3> Bounds(const char* key) const {
    const json& values = Member(Member(meta_, "means"), key);
    std::array<double, 3> bounds{};
    bool is_good = values.is_array() && values.size() == bounds.size();
    for (std::size_t k = 0; is_good && k < bounds.size(); ++k) {
      is_good = values[k].is_number() && std::isfinite(values[k].get<double>());
      if (is_good) bounds[k] = values[k].get<double>();
    }
    if (!is_good) FailMeta(fmt::format("{} of the means are not three finite numbers", key));
    return bounds;
  }

  // Entries that the file lacks are NaN.
  NumberPalette Codebook(const json& property) const {
    const json& values = Member(property, "codebook");
    NumberPalette palette;
    palette.fill(std::numeric_limits<float>::quiet_NaN());
    if (!values.is_array() || values.size() > palette.size()) {
      FailMeta(fmt::format("a codebook is not a list of up to {} numbers", palette.size()));
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (values[i].is_number()) palette[i] = static_cast<float>(values[i].get<double>());
    }
    // Early versions of splat-transform wrote null first; PlayCanvas replaces it so.
    if (!values.empty() && values[0].is_null()) palette[0] = palette[1] + (palette[1] - palette[255]) / 255;
    return palette;
  }

  // Reads file `index` of a property. Only files in the archive, or in the folder of meta.json, are read.
  std::string Read(const json& property, std::size_t index) const {
    const json& files = Member(property, "files");
    if (!files.is_array() || files.size() <= index || !files[index].is_string()) FailMeta("a file name is missing");
    const auto name = files[index].get<std::string>();
    if (zip_) return zip_->Read(name);
    const std::filesystem::path file(name);
    if (name.empty() || file.filename() != file || name == "." || name == "..") {
      FailMeta(fmt::format("'{}' is not a file name", Printable(name)));
    }
    return ReadFile(std::filesystem::path(path_).replace_filename(file).string());
  }

  const std::string& path() const { return path_; }

 private:
  std::string path_;
  std::unique_ptr<ZipReader> zip_;
  json meta_;
};

// An image with 8 bits per sample.
class Texture {
 public:
  // Checks the size in the header before it decodes the image. is_valid: whether a size fits.
  Texture(const SogFiles& files, const char* name, const std::string& bytes,
          const std::function<bool(ImageSize size)>& is_valid) {
    const std::string where = fmt::format("{}: image {}", files.path(), name);
    if (!bytes.starts_with("RIFF")) Fail(kUnsupported, "{} is not a WebP; export the splat again", where);
    const ImageSize size = DecodeWebp(where, bytes, true).size;
    if (!is_valid(size)) {
      Fail(kBadFile, "{} has {} x {} pixels, which does not fit the count in {}; export the splat again", where,
           size.width, size.height, sog::kMetaFile);
    }
    image_ = DecodeWebp(where, bytes, false);
  }
  // Three samples, or four if has_alpha.
  const std::uint8_t* at(Index pixel) const {
    return image_.bytes.data() + static_cast<std::size_t>(pixel) * image_.samples;
  }
  std::uint8_t alpha(Index pixel) const { return image_.samples == 4 ? at(pixel)[3] : 255; }

 private:
  InterleavedImage image_;
};

// Sets the coefficients above degree 0.
void ReadPalette(const SogFiles& files, const Texture& labels, const Texture& entries, Index num_entries,
                 const NumberPalette& numbers, SplatModel* model) {
  const Index rest = sog::HigherCoefficients(model->sh_degree);
  ParallelFor(model->count, 1024, [&](Index i) {
    const Index entry = labels.at(i)[0] | labels.at(i)[1] << 8;
    if (entry >= num_entries) {
      Fail(kBadFile, "{}: a Gaussian has entry {} of an SH palette with {}; export the splat again", files.path(),
           entry, num_entries);
    }
    for (Index k = 0; k < rest; ++k) {
      const std::uint8_t* pixel = entries.at(entry * rest + k);
      for (int channel = 0; channel < 3; ++channel) {
        model->attribute(splat::kSh + 3 * static_cast<int>(1 + k) + channel)[i] = numbers[pixel[channel]];
      }
    }
  });
}

bool IsAntialiased(const json& meta) {
  return meta.value("antialias", json()) == true || meta.value("model", json()) == sog::kAntialiased;
}

std::vector<std::string> Comments(const json& meta) {
  std::vector<std::string> comments;
  const json extras = meta.value("extras", json());
  if (!extras.is_object() || !extras.contains("vesta") || !extras["vesta"].is_array()) return comments;
  for (const json& line : extras["vesta"]) {
    if (line.is_string()) comments.push_back(line.get<std::string>());
  }
  return comments;
}

}  // namespace

bool IsSog(std::string_view bytes) { return IsZip(bytes) || NextWord(&bytes).starts_with('{'); }

SplatModel ReadSog(const std::string& path, std::vector<std::string>* notes) {
  return ReadSog(path, ReadFile(path), notes);
}

SplatModel ReadSog(const std::string& path, std::string_view bytes, std::vector<std::string>* notes) {
  const SogFiles files(path, bytes);
  const json& meta = files.meta();
  const Index count = files.Count(meta, "count", std::numeric_limits<std::int32_t>::max());
  const std::array<double, 3> low = files.Bounds("mins"), high = files.Bounds("maxs");
  const json &scales = files.Member(meta, "scales"), &sh0 = files.Member(meta, "sh0");
  const NumberPalette log_scales = files.Codebook(scales), colors = files.Codebook(sh0);
  const std::string lower_bytes = files.Read(files.Member(meta, "means"), 0),
                    upper_bytes = files.Read(files.Member(meta, "means"), 1);
  // A hundred bytes of WebP can be any number of equal pixels, but the means of a splat are all different.
  constexpr Index kMostPerByte = 64;
  if (count / kMostPerByte > static_cast<Index>(lower_bytes.size() + upper_bytes.size())) {
    Fail(kBadFile, "{}: {} counts {} Gaussians, too many for images of {} bytes; export the splat again", path,
         sog::kMetaFile, count, lower_bytes.size() + upper_bytes.size());
  }
  const auto fits = [count](ImageSize size) {
    constexpr double kMostUnused = 1 << 16;  // pixels, beside three times the count
    const auto most = static_cast<double>(count);
    return size.pixels() >= most && size.pixels() <= 4 * most + kMostUnused;
  };
  const Texture lower(files, "means_l", lower_bytes, fits), upper(files, "means_u", upper_bytes, fits),
      rotations(files, "quats", files.Read(files.Member(meta, "quats"), 0), fits),
      scale_indices(files, "scales", files.Read(scales, 0), fits),
      color_indices(files, "sh0", files.Read(sh0, 0), fits);

  const bool has_palette = meta.contains("shN") && !meta["shN"].is_null();
  SplatModel model;
  model.Resize(has_palette ? static_cast<int>(files.Count(meta["shN"], "bands", splat::kMaxShDegree)) : 0, count);
  model.antialiased = IsAntialiased(meta);
  ReadSplatComments(path, Comments(meta), &model);
  ParallelFor(count, 1024, [&](Index i) {
    SmallestThree three{rotations.alpha(i) - sog::kFirstTag, {}};
    for (int k = 0; k < 3; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const double part = (lower.at(i)[k] | upper.at(i)[k] << 8) / sog::kMeanSteps;
      model.attribute(splat::kMean + k)[i] = static_cast<float>(sog::MeanOfLog(low[at] * (1 - part) + high[at] * part));
      model.attribute(splat::kLogScale + k)[i] = log_scales[scale_indices.at(i)[k]];
      model.attribute(splat::kSh + k)[i] = colors[color_indices.at(i)[k]];
      three.rest[at] = (rotations.at(i)[k] / sog::kRotationScale - 1) * kLargestOfSmallest;
    }
    model.attribute(splat::kOpacity)[i] = OpacityLogit(color_indices.alpha(i));
    // Other tags have no meaning: the quaternion stays zero.
    if (three.largest < 0) return;
    const std::array<double, 4> q = FromSmallestThree(three);
    for (int k = 0; k < 4; ++k)
      model.attribute(splat::kQuaternion + k)[i] = static_cast<float>(q[static_cast<std::size_t>(k)]);
  });
  if (has_palette) {
    const json& palette = meta["shN"];
    const Index num_entries = files.Count(palette, "count", sog::kMostEntries);
    const Texture entries(files, "shN_centroids", files.Read(palette, 0), [&](ImageSize size) {
      return size.width == sog::kEntriesPerRow * sog::HigherCoefficients(model.sh_degree) &&
             size.height >= (num_entries - 1) / sog::kEntriesPerRow + 1 &&
             size.height <= sog::kMostEntries / sog::kEntriesPerRow;
    });
    const Texture labels(files, "shN_labels", files.Read(palette, 1), fits);
    ReadPalette(files, labels, entries, num_entries, files.Codebook(palette), &model);
  }
  RemoveUnusableGaussians(path, notes, &model);
  return AtStoredDegrees(std::move(model));
}

}  // namespace vesta::gs

// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/bytes/zip.h"

#include <zip.h>

#include <new>
#include <utility>

#include "kernels/core/check.h"
#include "splatting/io/bytes/bytes.h"

namespace vesta::gs {
namespace {

struct ZipCloser {
  void operator()(zip_t* archive) const { zip_discard(archive); }
  void operator()(zip_source_t* source) const { zip_source_free(source); }
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};
using ZipArchive = std::unique_ptr<zip_t, ZipCloser>;
using ZipSource = std::unique_ptr<zip_source_t, ZipCloser>;
using ZipFile = std::unique_ptr<zip_file_t, ZipCloser>;

// An error of libzip as text.
struct ZipError {
  zip_error_t error{};
  ZipError() { zip_error_init(&error); }
  ~ZipError() { zip_error_fini(&error); }
  ZipError(const ZipError&) = delete;
  ZipError& operator=(const ZipError&) = delete;
};

// The archive takes a reference to the source.
ZipArchive Open(zip_source_t* source, int flags, ZipError* error) {
  zip_source_keep(source);
  ZipArchive archive(zip_open_from_source(source, flags, &error->error));
  if (archive == nullptr) zip_source_free(source);
  return archive;
}

}  // namespace

struct ZipReader::State {
  ZipSource source;
  ZipArchive archive;
};

ZipReader::ZipReader(std::string path, std::string_view bytes)
    : path_(std::move(path)), size_(bytes.size()), state_(std::make_unique<State>()) {
  ZipError error;
  state_->source.reset(zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error.error));
  if (state_->source == nullptr) throw std::bad_alloc();
  state_->archive = Open(state_->source.get(), ZIP_RDONLY, &error);
  if (state_->archive == nullptr) {
    Fail(kBadFile, "{}: the zip archive is truncated or damaged ({}); copy or export it again", path_,
         zip_error_strerror(&error.error));
  }
}

ZipReader::~ZipReader() = default;

std::string ZipReader::Read(const std::string& name) const {
  zip_t* archive = state_->archive.get();
  zip_stat_t stat;
  if (zip_stat(archive, name.c_str(), 0, &stat) != 0 || (stat.valid & ZIP_STAT_SIZE) == 0) {
    Fail(kBadFile, "{}: the archive has no file {}; export it again", path_, Printable(name));
  }
  if (stat.size / kMostDeflateExpands > size_) {
    Fail(kBadFile, "{}: {} in the archive has {} bytes, too many for an archive of {}; copy or export it again", path_,
         Printable(name), stat.size, size_);
  }
  std::string bytes(stat.size, '\0');
  const ZipFile file(zip_fopen(archive, name.c_str(), 0));
  // At the end, libzip checks the CRC.
  char more = 0;
  if (file == nullptr || zip_fread(file.get(), bytes.data(), bytes.size()) != static_cast<zip_int64_t>(bytes.size()) ||
      zip_fread(file.get(), &more, 1) != 0) {
    Fail(kBadFile, "{}: {} in the archive is damaged, encrypted or compressed in an unknown way; export it again",
         path_, Printable(name));
  }
  return bytes;
}

std::string Zip(const std::vector<ZipEntry>& entries) {
  constexpr zip_uint16_t kFirstDate = 1 << 5 | 1;  // 1 January 1980, so that equal files give equal archives
  ZipError error;
  const ZipSource target(zip_source_buffer_create(nullptr, 0, 0, &error.error));
  if (target == nullptr) throw std::bad_alloc();
  ZipArchive archive = Open(target.get(), ZIP_TRUNCATE, &error);
  bool is_good = archive != nullptr;
  for (const auto& [name, bytes] : entries) {
    if (!is_good) break;
    zip_source_t* source = zip_source_buffer(archive.get(), bytes.data(), bytes.size(), 0);
    const zip_int64_t index = zip_file_add(archive.get(), name.c_str(), source, ZIP_FL_ENC_UTF_8);
    if (index < 0) zip_source_free(source);
    const auto at = static_cast<zip_uint64_t>(index);
    is_good = index >= 0 && zip_set_file_compression(archive.get(), at, ZIP_CM_STORE, 0) == 0 &&
              zip_file_set_dostime(archive.get(), at, 0, kFirstDate, 0) == 0;
  }
  if (is_good && zip_close(archive.get()) == 0) {
    (void)archive.release();
    zip_stat_t stat;
    std::string bytes;
    if (zip_source_stat(target.get(), &stat) == 0 && zip_source_open(target.get()) == 0) {
      bytes.resize(stat.size);
      const zip_int64_t read = zip_source_read(target.get(), bytes.data(), bytes.size());
      zip_source_close(target.get());
      if (read == static_cast<zip_int64_t>(bytes.size())) return bytes;
    }
  }
  Fail(kCannotWrite, "libzip cannot make an archive of {} files", entries.size());
}

}  // namespace vesta::gs

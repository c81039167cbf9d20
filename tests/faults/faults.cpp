// A library to be preloaded (LD_PRELOAD) that makes one call of the system fail, or kills the program before it.
//
//   ISOPACH_FAULT=KIND:N        the N-th call of that kind, counted from 1 over all threads
//   ISOPACH_FAULT_DO=fail|kill  fail: it returns an error (default); kill: SIGKILL before it is done
//   ISOPACH_FAULT_COUNT=FILE    at the end of the program the number of calls of that kind is written there
//
// KIND: memory (64 kB or more at once: what is less does not fail where memory is lent before it is there), open, read,
// write (but to standard output and error), rename, fsync, mkdir, remove, thread; step: every one of those that change
// the disk.
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

enum Kind : unsigned {
  none = 0,
  memory = 1,
  open_file = 2,
  read_file = 4,
  write_file = 8,
  rename_file = 16,
  sync_file = 32,
  make_folder = 64,
  remove_file = 128,
  thread_start = 256,
  step = 512
};

struct Name {
  const char* name;
  unsigned kind;
};
constexpr Name names[] = {{"memory", memory},     {"open", open_file},     {"read", read_file},
                          {"write", write_file},  {"rename", rename_file}, {"fsync", sync_file},
                          {"mkdir", make_folder}, {"remove", remove_file}, {"thread", thread_start},
                          {"step", step}};

// Set before main and read only afterwards; the counter alone is shared.
unsigned wanted = none;
long wanted_number = 0;
bool kills = false;
std::atomic<long> calls{0};

__attribute__((constructor)) void set_up() {
  const char* const text = std::getenv("ISOPACH_FAULT");
  const char* const deed = std::getenv("ISOPACH_FAULT_DO");
  kills = deed != nullptr && std::strcmp(deed, "kill") == 0;
  const char* const colon = text != nullptr ? std::strchr(text, ':') : nullptr;
  if (colon == nullptr) return;
  wanted_number = std::atol(colon + 1);
  for (const Name& n : names)
    if (std::strlen(n.name) == static_cast<std::size_t>(colon - text) && std::strncmp(n.name, text, colon - text) == 0)
      wanted = n.kind;
}

// True where this call is to fail.
bool strikes(unsigned kind) {
  if ((kind & wanted) == 0 || calls.fetch_add(1) + 1 != wanted_number) return false;
  if (kills) raise(SIGKILL);
  return true;
}

template <class F>
F real(F, const char* name) {
  return reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
}

int failed(int error) {
  errno = error;
  return -1;
}

constexpr std::size_t large = std::size_t{64} << 10;

bool writes(int flags) { return (flags & O_ACCMODE) != O_RDONLY; }
bool writes(const char* mode) { return std::strpbrk(mode, "wa+") != nullptr; }
unsigned opening(bool for_writing) { return open_file | (for_writing ? step : none); }
bool is_message(int descriptor) { return descriptor == 1 || descriptor == 2; }

}  // namespace

extern "C" {

__attribute__((destructor)) void tell_count() {
  const char* const path = std::getenv("ISOPACH_FAULT_COUNT");
  if (path == nullptr) return;
  wanted = none;
  if (std::FILE* const file = std::fopen(path, "w")) {
    std::fprintf(file, "%ld\n", calls.load());
    std::fclose(file);
  }
}

void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);

void* malloc(std::size_t size) {
  if (size >= large && strikes(memory)) return errno = ENOMEM, nullptr;
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) {
  if (size != 0 && n >= large / size && strikes(memory)) return errno = ENOMEM, nullptr;
  return __libc_calloc(n, size);
}
void* realloc(void* p, std::size_t size) {
  if (size >= large && strikes(memory)) return errno = ENOMEM, nullptr;
  return __libc_realloc(p, size);
}

#define WITH_MODE(flags, mode)                  \
  mode_t mode = 0;                              \
  if (((flags) & (O_CREAT | O_TMPFILE)) != 0) { \
    va_list rest;                               \
    va_start(rest, flags);                      \
    mode = va_arg(rest, mode_t);                \
    va_end(rest);                               \
  }

int open(const char* path, int flags, ...) {
  WITH_MODE(flags, mode)
  static const auto next = real(&open, "open");
  return strikes(opening(writes(flags))) ? failed(writes(flags) ? ENOSPC : EMFILE) : next(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  WITH_MODE(flags, mode)
  static const auto next = real(&open64, "open64");
  return strikes(opening(writes(flags))) ? failed(writes(flags) ? ENOSPC : EMFILE) : next(path, flags, mode);
}
int openat(int at, const char* path, int flags, ...) {
  WITH_MODE(flags, mode)
  static const auto next = real(&openat, "openat");
  return strikes(opening(writes(flags))) ? failed(writes(flags) ? ENOSPC : EMFILE) : next(at, path, flags, mode);
}
std::FILE* fopen(const char* path, const char* mode) {
  static const auto next = real(&fopen, "fopen");
  if (strikes(opening(writes(mode)))) return errno = writes(mode) ? ENOSPC : EMFILE, nullptr;
  return next(path, mode);
}
std::FILE* fopen64(const char* path, const char* mode) {
  static const auto next = real(&fopen64, "fopen64");
  if (strikes(opening(writes(mode)))) return errno = writes(mode) ? ENOSPC : EMFILE, nullptr;
  return next(path, mode);
}

ssize_t read(int descriptor, void* to, std::size_t size) {
  static const auto next = real(&read, "read");
  return strikes(read_file) ? failed(EIO) : next(descriptor, to, size);
}
ssize_t write(int descriptor, const void* from, std::size_t size) {
  static const auto next = real(&write, "write");
  return !is_message(descriptor) && strikes(write_file | step) ? failed(ENOSPC) : next(descriptor, from, size);
}
ssize_t writev(int descriptor, const iovec* parts, int count) {
  static const auto next = real(&writev, "writev");
  return !is_message(descriptor) && strikes(write_file | step) ? failed(ENOSPC) : next(descriptor, parts, count);
}
std::size_t fwrite(const void* from, std::size_t size, std::size_t count, std::FILE* file) {
  static const auto next = real(&fwrite, "fwrite");
  if (!is_message(fileno(file)) && strikes(write_file | step)) return errno = ENOSPC, 0;
  return next(from, size, count, file);
}

int rename(const char* from, const char* to) {
  static const auto next = real(&rename, "rename");
  return strikes(rename_file | step) ? failed(EIO) : next(from, to);
}
int fsync(int descriptor) {
  static const auto next = real(&fsync, "fsync");
  return strikes(sync_file | step) ? failed(EIO) : next(descriptor);
}
int mkdir(const char* path, mode_t mode) {
  static const auto next = real(&mkdir, "mkdir");
  return strikes(make_folder | step) ? failed(ENOSPC) : next(path, mode);
}
int unlink(const char* path) {
  static const auto next = real(&unlink, "unlink");
  return strikes(remove_file | step) ? failed(EIO) : next(path);
}
int unlinkat(int at, const char* path, int flags) {
  static const auto next = real(&unlinkat, "unlinkat");
  return strikes(remove_file | step) ? failed(EIO) : next(at, path, flags);
}
int remove(const char* path) {
  static const auto next = real(static_cast<int (*)(const char*)>(&remove), "remove");
  return strikes(remove_file | step) ? failed(EIO) : next(path);
}
int rmdir(const char* path) {
  static const auto next = real(&rmdir, "rmdir");
  return strikes(remove_file | step) ? failed(EIO) : next(path);
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*work)(void*), void* with) {
  static const auto next = real(&pthread_create, "pthread_create");
  return strikes(thread_start) ? EAGAIN : next(thread, attributes, work, with);
}

}  // extern "C"

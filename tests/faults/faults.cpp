// A library to be preloaded (LD_PRELOAD) that makes one call of the system fail, or kills the program before it.
//
//   ISOPACH_FAULT=KIND:N        the N-th call of that kind, counted from 1 over all threads
//   ISOPACH_FAULT_DO=fail|kill|short|again
//                               fail: it returns an error (default); kill: SIGKILL before it is done; short: a read or
//                               write does half of what was asked; again: it is interrupted by a signal (EINTR)
//   ISOPACH_FAULT_LEAST=BYTES   requests of memory below this size neither fail nor count (default 65536)
//   ISOPACH_FAULT_COUNT=FILE    at the end of the program the number of calls of that kind is written there
//   ISOPACH_FAULT_CRASH=FILE    where the program crashes, the calls it stood in are written there
//
// KIND: memory, open, read, write (but to standard output and error), close, rename, fsync, mkdir, remove, thread,
// stat, list (of a folder), lock; step: every one of those that change the disk; all: none fails, and the FILE of the
// count gets every kind with its number.
#include <dirent.h>
#include <dlfcn.h>
#include <execinfo.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/file.h>
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
  step = 512,
  close_file = 1024,
  stat_file = 2048,
  list_folder = 4096,
  lock_file = 8192
};

struct Name {
  const char* name;
  unsigned kind;
};
constexpr Name names[] = {{"memory", memory},     {"open", open_file},     {"read", read_file},
                          {"write", write_file},  {"rename", rename_file}, {"fsync", sync_file},
                          {"mkdir", make_folder}, {"remove", remove_file}, {"thread", thread_start},
                          {"step", step},         {"close", close_file},   {"stat", stat_file},
                          {"list", list_folder},  {"lock", lock_file}};

// Set before main and read only afterwards; the counter alone is shared.
unsigned wanted = none;
long wanted_number = 0;
enum class Deed { fail, kill, shorten, interrupt };
Deed deed = Deed::fail;
std::size_t least_memory = std::size_t{64} << 10;
std::atomic<long> calls{0};
bool counts_all = false;
std::atomic<long> calls_of[sizeof names / sizeof names[0]];

void tell_place(int signal) {
  void* frames[48];
  const int count = backtrace(frames, 48);
  const int file = ::open(std::getenv("ISOPACH_FAULT_CRASH"), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file >= 0) backtrace_symbols_fd(frames, count, file);
  std::signal(signal, SIG_DFL);
  raise(signal);
}

void watch_for_crashes() {
  if (std::getenv("ISOPACH_FAULT_CRASH") == nullptr) return;
  void* first[1];
  (void)backtrace(first, 1);  // loads what it needs now, not in a crash
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL}) std::signal(signal, tell_place);
}

__attribute__((constructor)) void set_up() {
  watch_for_crashes();
  const char* const text = std::getenv("ISOPACH_FAULT");
  if (const char* const word = std::getenv("ISOPACH_FAULT_DO")) {
    if (std::strcmp(word, "kill") == 0) deed = Deed::kill;
    if (std::strcmp(word, "short") == 0) deed = Deed::shorten;
    if (std::strcmp(word, "again") == 0) deed = Deed::interrupt;
  }
  if (const char* const bytes = std::getenv("ISOPACH_FAULT_LEAST"))
    least_memory = static_cast<std::size_t>(std::atol(bytes));
  const char* const colon = text != nullptr ? std::strchr(text, ':') : nullptr;
  if (colon == nullptr) return;
  wanted_number = std::atol(colon + 1);
  counts_all = std::strncmp(text, "all:", 4) == 0;
  for (const Name& n : names)
    if (std::strlen(n.name) == static_cast<std::size_t>(colon - text) && std::strncmp(n.name, text, colon - text) == 0)
      wanted = n.kind;
}

// True where this call is to fail.
bool strikes(unsigned kind) {
  if (counts_all)
    for (std::size_t k = 0; k < sizeof names / sizeof names[0]; ++k)
      if ((names[k].kind & kind) != 0) calls_of[k].fetch_add(1);
  if ((kind & wanted) == 0 || calls.fetch_add(1) + 1 != wanted_number) return false;
  if (deed == Deed::kill) raise(SIGKILL);
  return true;
}

// The error that a call is to end with; 0 where it is to be done.
int error_of(unsigned kind, int error) {
  if (!strikes(kind) || deed == Deed::shorten) return 0;
  return deed == Deed::interrupt ? EINTR : error;
}

template <class F>
F real(F, const char* name) {
  return reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
}

int failed(int error) {
  errno = error;
  return -1;
}

bool writes(int flags) { return (flags & O_ACCMODE) != O_RDONLY; }
bool writes(const char* mode) { return std::strpbrk(mode, "wa+") != nullptr; }
unsigned opening(bool for_writing) { return open_file | (for_writing ? step : none); }
bool is_message(int descriptor) { return descriptor == 1 || descriptor == 2; }

}  // namespace

extern "C" {

__attribute__((destructor)) void tell_count() {
  const char* const path = std::getenv("ISOPACH_FAULT_COUNT");
  if (path == nullptr) return;
  const bool all = counts_all;
  wanted = none, counts_all = false;
  std::FILE* const file = std::fopen(path, "w");
  if (file == nullptr) return;
  if (!all) std::fprintf(file, "%ld\n", calls.load());
  for (std::size_t k = 0; all && k < sizeof names / sizeof names[0]; ++k)
    std::fprintf(file, "%s %ld\n", names[k].name, calls_of[k].load());
  std::fclose(file);
}

void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);

void* malloc(std::size_t size) {
  if (size >= least_memory && strikes(memory)) return errno = ENOMEM, nullptr;
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) {
  if (size != 0 && n >= least_memory / size && strikes(memory)) return errno = ENOMEM, nullptr;
  return __libc_calloc(n, size);
}
void* realloc(void* p, std::size_t size) {
  if (size >= least_memory && strikes(memory)) return errno = ENOMEM, nullptr;
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
  const int error = error_of(opening(writes(flags)), writes(flags) ? ENOSPC : EMFILE);
  return error != 0 ? failed(error) : next(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  WITH_MODE(flags, mode)
  static const auto next = real(&open64, "open64");
  const int error = error_of(opening(writes(flags)), writes(flags) ? ENOSPC : EMFILE);
  return error != 0 ? failed(error) : next(path, flags, mode);
}
int openat(int at, const char* path, int flags, ...) {
  WITH_MODE(flags, mode)
  static const auto next = real(&openat, "openat");
  const int error = error_of(opening(writes(flags)), writes(flags) ? ENOSPC : EMFILE);
  return error != 0 ? failed(error) : next(at, path, flags, mode);
}
std::FILE* fopen(const char* path, const char* mode) {
  static const auto next = real(&fopen, "fopen");
  const int error = error_of(opening(writes(mode)), writes(mode) ? ENOSPC : EMFILE);
  if (error != 0) return errno = error, nullptr;
  return next(path, mode);
}
std::FILE* fopen64(const char* path, const char* mode) {
  static const auto next = real(&fopen64, "fopen64");
  const int error = error_of(opening(writes(mode)), writes(mode) ? ENOSPC : EMFILE);
  if (error != 0) return errno = error, nullptr;
  return next(path, mode);
}

ssize_t read(int descriptor, void* to, std::size_t size) {
  static const auto next = real(&read, "read");
  if (!strikes(read_file)) return next(descriptor, to, size);
  if (deed == Deed::shorten) return next(descriptor, to, (size + 1) / 2);
  return failed(deed == Deed::interrupt ? EINTR : EIO);
}
ssize_t write(int descriptor, const void* from, std::size_t size) {
  static const auto next = real(&write, "write");
  if (is_message(descriptor) || !strikes(write_file | step)) return next(descriptor, from, size);
  if (deed == Deed::shorten) return next(descriptor, from, (size + 1) / 2);
  return failed(deed == Deed::interrupt ? EINTR : ENOSPC);
}
ssize_t writev(int descriptor, const iovec* parts, int count) {
  static const auto next = real(&writev, "writev");
  if (is_message(descriptor) || !strikes(write_file | step)) return next(descriptor, parts, count);
  if (deed == Deed::shorten) return next(descriptor, parts, 1);
  return failed(deed == Deed::interrupt ? EINTR : ENOSPC);
}
std::size_t fwrite(const void* from, std::size_t size, std::size_t count, std::FILE* file) {
  static const auto next = real(&fwrite, "fwrite");
  if (is_message(fileno(file)) || deed == Deed::shorten || deed == Deed::interrupt || !strikes(write_file | step))
    return next(from, size, count, file);
  return errno = ENOSPC, 0;
}
int close(int descriptor) {
  static const auto next = real(&close, "close");
  if (is_message(descriptor)) return next(descriptor);
  const int error = error_of(close_file, EIO);
  const int result = next(descriptor);  // it is closed all the same, as Linux has it
  return error != 0 ? failed(error) : result;
}
int fclose(std::FILE* file) {
  static const auto next = real(&fclose, "fclose");
  const int error = error_of(close_file, EIO);
  const int result = next(file);
  if (error != 0) return errno = error, EOF;
  return result;
}

int stat(const char* path, struct stat* to) {
  static const auto next = real(static_cast<int (*)(const char*, struct stat*)>(&stat), "stat");
  const int error = error_of(stat_file, EIO);
  return error != 0 ? failed(error) : next(path, to);
}
int lstat(const char* path, struct stat* to) {
  static const auto next = real(&lstat, "lstat");
  const int error = error_of(stat_file, EIO);
  return error != 0 ? failed(error) : next(path, to);
}
int fstat(int descriptor, struct stat* to) {
  static const auto next = real(&fstat, "fstat");
  const int error = error_of(stat_file, EIO);
  return error != 0 ? failed(error) : next(descriptor, to);
}
DIR* opendir(const char* path) {
  static const auto next = real(&opendir, "opendir");
  const int error = error_of(list_folder, EMFILE);
  if (error != 0) return errno = error, nullptr;
  return next(path);
}
dirent* readdir(DIR* folder) {
  static const auto next = real(&readdir, "readdir");
  const int error = error_of(list_folder, EIO);
  if (error != 0) return errno = error, nullptr;
  return next(folder);
}
int flock(int descriptor, int operation) {
  static const auto next = real(&flock, "flock");
  const int error = error_of(lock_file, ENOLCK);
  return error != 0 ? failed(error) : next(descriptor, operation);
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

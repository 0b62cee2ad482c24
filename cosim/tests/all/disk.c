/* Records what a program does to files, a line for each successful call (LD_PRELOAD): see
 * durability.rs. A file is identified by its inode. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

static void note(const char *format, ...) {
  const char *name = getenv("DISK_LOG");
  char line[9000];
  va_list list;
  va_start(list, format);
  const int length = vsnprintf(line, sizeof line, format, list);
  va_end(list);
  const int file = name ? syscall(SYS_openat, AT_FDCWD, name, O_WRONLY | O_CREAT | O_APPEND, 0600) : -1;
  if (file < 0) return;
  syscall(SYS_write, file, line, length);
  syscall(SYS_close, file);
}
static const char *full(const char *name, char *room) {
  if (name[0] == '/') return name;
  char folder[4096];
  if (!getcwd(folder, sizeof folder)) return name;
  if (!strncmp(name, "./", 2)) name += 2;
  snprintf(room, 8192, "%s/%s", folder, name);
  return room;
}
static unsigned long number(int file, int *kind) {
  struct stat status;
  if (fstat(file, &status)) return 0;
  *kind = status.st_mode & S_IFMT;
  return status.st_ino;
}
static int opened(int file, const char *name, int flags) {
  int kind = 0;
  char room[8192];
  if (file >= 0 && (flags & O_ACCMODE) != O_RDONLY && (flags & O_TMPFILE) != O_TMPFILE) {
    const unsigned long inode = number(file, &kind);
    if (kind == S_IFREG && (flags & (O_CREAT | O_TRUNC))) note("create\t%lu\t%s\n", inode, full(name, room));
  }
  return file;
}
#define OPEN(NAME)                                                              \
  int NAME(const char *name, int flags, ...) {                                 \
    va_list list;                                                              \
    va_start(list, flags);                                                     \
    const int mode = va_arg(list, int);                                        \
    va_end(list);                                                              \
    return opened(syscall(SYS_openat, AT_FDCWD, name, flags, mode), name, flags); \
  }
OPEN(open)
OPEN(open64)
ssize_t write(int file, const void *bytes, size_t count) {
  int kind = 0;
  const ssize_t done = syscall(SYS_write, file, bytes, count);
  const unsigned long inode = number(file, &kind);
  if (done > 0 && kind == S_IFREG) note("write\t%lu\t%zd\n", inode, done);
  return done;
}
static int synced(int file, long result) {
  int kind = 0;
  const unsigned long inode = number(file, &kind);
  if (!result && kind == S_IFREG) note("sync\t%lu\n", inode);
  if (!result && kind == S_IFDIR) {
    char link[64], folder[4096];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    const ssize_t length = readlink(link, folder, sizeof folder - 1);
    if (length > 0) folder[length] = 0, note("folder\t%s\n", folder);
  }
  return result;
}
int fsync(int file) { return synced(file, syscall(SYS_fsync, file)); }
int fdatasync(int file) { return synced(file, syscall(SYS_fdatasync, file)); }
int rename(const char *from, const char *to) {
  char a[8192], b[8192];
  const int result = syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0);
  if (!result) note("rename\t%s\t%s\n", full(from, a), full(to, b));
  return result;
}
int unlink(const char *name) {
  char room[8192];
  const int result = syscall(SYS_unlinkat, AT_FDCWD, name, 0);
  if (!result) note("remove\t%s\n", full(name, room));
  return result;
}
int linkat(int from_folder, const char *from, int to_folder, const char *to, int flags) {
  struct stat status;
  char room[8192];
  const int result = syscall(SYS_linkat, from_folder, from, to_folder, to, flags);
  if (!result && !stat(to, &status)) note("link\t%lu\t%s\n", status.st_ino, full(to, room));
  return result;
}

/* FMI 2.0 co-simulation FMUs for tests, not written in Rust. -DMODEL_x chooses the behaviour;
 * the descriptions are in models.rs. Written from the standard, without its headers. */
#define _GNU_SOURCE
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <unistd.h>
#if defined ATTACK || defined DOES_AT
#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <fenv.h>
#include <locale.h>
#include <sched.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#endif
#ifdef MODEL_NOSY
#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <sys/socket.h>
#endif

typedef void *Component;
typedef unsigned int Ref;
typedef int Status; /* 0 OK, 1 Warning, 2 Discard, 3 Error, 4 Fatal */
typedef void (*Logger)(void *, const char *, Status, const char *, const char *, ...);
typedef struct {
  Logger log;
  void *(*allocate)(size_t, size_t);
  void (*release)(void *);
  void *step_finished;
  void *environment;
} Callbacks;

#ifdef FIRST_INCARNATION
/* Whether this process was started to compute the first incarnation of a group. */
static int is_first_incarnation(void) {
  char line[4096];
  FILE *file = fopen("/proc/self/cmdline", "r");
  size_t count = file ? fread(line, 1, sizeof line, file) : 0;
  if (file) fclose(file);
  return memmem(line, count, "--generation\0" "1", 15) != NULL;
}
/* Waits until the process is killed; the name of the thread shows that it got here. */
static void wait_for_the_end(void) {
  prctl(PR_SET_NAME, "waiting");
  for (;;) pause();
}
#endif

typedef struct {
  const Callbacks *callbacks;
  double r[4];  /* 0 u, 1 k, 2 y, 3 second parameter */
  double slope; /* of u, during the next step */
  double x, v;  /* of the oscillators */
  int i[4], b[4];
  double time;
  double reached; /* of a discarded step */
  int ended;
  int steps;
  int mode; /* 0 before, 1 in, 2 after initialization mode */
  double stop;
  char name[64], text[64];
  int debug, pending;
  double first_step;
  pthread_t thread;
} Model;

/* What FMUs in the field pass to the logger instead of the environment that they were given. */
#if defined ENVIRONMENT_IS_COMPONENT
#define ENVIRONMENT(m) (m)
#elif defined ENVIRONMENT_IS_ONE
#define ENVIRONMENT(m) ((void *)1)
#else
#define ENVIRONMENT(m) (m)->callbacks->environment
#endif
#define SAY(STATUS, ...)                                                           \
  m->callbacks->log(ENVIRONMENT(m), m->name, STATUS, __VA_ARGS__)
#ifdef CHATTERS
#define REPORT(...) SAY(0, "logAll", __VA_ARGS__)
#else
#define REPORT(...)
#endif
#ifdef WARNS_ALWAYS
#define WELL 1
#else
#define WELL 0
#endif

#ifdef DOES_AT
/* -DDOES=... runs at one place of a life. */
static void leave(void) { _exit(0); }
static void at(const char *place) {
  if (!strcmp(place, DOES_AT)) { DOES; }
}
__attribute__((constructor)) static void constructed(void) { at("constructor"); }
__attribute__((destructor)) static void destructed(void) { at("destructor"); }
#else
#define at(place)
#endif
#ifdef ATTACK
/* -DATTACK=... runs in a step, and logs its outcome with REPORT(result). */
static const char *outcome(long result) { return result < 0 ? strerror(errno) : "done"; }
#undef REPORT
#define REPORT(RESULT) SAY(0, "logAll", "attack: %s", outcome(RESULT))
static const char *in_home(const char *name) {
  static char path[512];
  snprintf(path, sizeof path, "%s/%s", getenv("HOME") ? getenv("HOME") : "", name);
  return path;
}
/* Writes the id of this process, which continues after the run. */
static void linger(const char *name) {
  char unfinished[600];
  snprintf(unfinished, sizeof unfinished, "%s.unfinished", name);
  FILE *file = fopen(unfinished, "w");
  if (file) fprintf(file, "%d", (int)getpid()), fclose(file), rename(unfinished, name);
  for (;;) pause();
}
static int send_udp(int port) {
  struct sockaddr_in to = {.sin_family = AF_INET, .sin_port = htons(port)};
  const int line = socket(AF_INET, SOCK_DGRAM, 0);
  if (line < 0) return -1;
  inet_pton(AF_INET, "127.0.0.1", &to.sin_addr);
  return sendto(line, "x", 1, 0, (struct sockaddr *)&to, sizeof to);
}
/* Whether any other thread of this process can open a file. */
static const char *wanted;
static volatile int opened;
static void look(int number) {
  const int file = open(wanted, O_RDONLY);
  if (file >= 0) opened = 1, close(file);
}
static int read_elsewhere(const char *name) {
  const int own = getpid();
  wanted = name;
  signal(SIGURG, look); /* it is ignored before and after */
  for (int thread = own + 1; thread < own + 1000; thread++) syscall(SYS_tgkill, own, thread, SIGURG);
  for (int k = 0; k < 200 && !opened; k++) usleep(1000);
  signal(SIGURG, SIG_DFL);
  errno = EACCES;
  return opened - 1;
}
/* Lets a timer send a signal to this process: no call names both. */
static void timed(int number) {
  struct sigevent event = {.sigev_notify = SIGEV_SIGNAL, .sigev_signo = number};
  const struct itimerspec soon = {.it_value = {.tv_nsec = 1000}};
  timer_t timer;
  timer_create(CLOCK_MONOTONIC, &event, &timer);
  timer_settime(timer, 0, &soon, NULL);
  for (;;) pause();
}
static const char *in_proc(int process, const char *name) {
  static char path[64];
  snprintf(path, sizeof path, "/proc/%d/%s", process, name);
  return path;
}
static int read_file(const char *name) {
  char byte;
  const int file = open(name, O_RDONLY);
  return file < 0 ? -1 : (int)read(file, &byte, 1);
}
/* Starts a process in namespaces of its own, which ends at once. */
static long begin(long namespaces) {
  const long child = syscall(SYS_clone, namespaces | SIGCHLD, 0, 0, 0, 0);
  if (!child) syscall(SYS_exit_group, 0);
  return child;
}
#define TRY(CALL) SAY(0, "logAll", "tried %s: %s", #CALL, outcome(CALL))
static void attack(Model *m) { ATTACK; }
#undef REPORT
#define REPORT(...)
#endif

static void outputs(Model *m) {
#if defined MODEL_GAIN || defined MODEL_FAILING || defined MODEL_LOGGING || defined MODEL_NOSY
  m->r[2] = m->r[1] * m->r[0];
#ifdef UNDEFINED_AT_FIRST
  if (!m->steps) m->r[2] = 0.0 / 0.0;
#endif
#elif defined MODEL_AFFINE
  m->r[2] = m->r[1] * m->r[0] + m->time;
#elif defined MODEL_CUBIC
  m->r[2] = m->time - m->r[1] * m->r[0] * m->r[0] * m->r[0];
#elif defined MODEL_MASS
  m->r[2] = m->x;
#elif defined MODEL_INERTIA
  m->r[2] = m->r[0] - m->r[1] * m->x;
#elif defined MODEL_CLOCK
  m->r[2] = m->time;
#elif defined MODEL_COUNTER
  m->r[2] = m->steps;
  m->i[1] = m->steps + m->i[0];
  m->b[1] = !m->b[0];
#endif
}

#if defined MODEL_MASS || defined MODEL_INERTIA
/* x'' = force - k x by Runge-Kutta with steps so small that their error is negligible. */
static double pull(Model *m, double x, double t) {
  double u = m->r[0] + m->slope * t;
#ifdef MODEL_MASS
  u *= m->r[3];
#endif
  return u - m->r[1] * x;
}
static void oscillate(Model *m, double h) {
  const int n = 32;
  const double d = h / n;
  for (int i = 0; i < n; i++) {
    const double t = i * d, x = m->x, v = m->v;
    const double a1 = pull(m, x, t), v2 = v + a1 * d / 2;
    const double a2 = pull(m, x + v * d / 2, t + d / 2), v3 = v + a2 * d / 2;
    const double a3 = pull(m, x + v2 * d / 2, t + d / 2), v4 = v + a3 * d;
    const double a4 = pull(m, x + v3 * d, t + d);
    m->x += d / 6 * (v + 2 * v2 + 2 * v3 + v4);
    m->v += d / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
}
#endif

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) {
  at("version");
  return "2.0";
}

#ifdef NEEDS_ANOTHER_LIBRARY
double gain_of_another(void);
#endif
static void defaults(Model *m) {
#ifdef NEEDS_ANOTHER_LIBRARY
  m->r[1] = gain_of_another();
#else
  m->r[1] = 1;
#endif
  m->r[3] = 1e9;
}

#ifdef LEAVES_A_THREAD /* that continues after the instance is freed */
static void *go_on(void *argument) {
  for (volatile unsigned long k = 0;; k++) usleep(100);
  return NULL;
}
#endif
#ifdef LOGS_LATE /* by a thread, with the callbacks of the first instance, after it was freed */
static const Callbacks *first;
static volatile int wanted_logs, made_logs;
static void *log_late(void *argument) {
  for (;; usleep(100))
    if (made_logs < wanted_logs) {
      first->log(first->environment, "first", 0, "logAll", "late");
      first->release(first->allocate(1, 8));
      made_logs++;
    }
  return NULL;
}
#endif
Component fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                          const Callbacks *callbacks, int visible, int logging) {
  if (strcmp(guid, "{test}") || type != 1 || strncmp(resources, "file:///", 8)) {
    callbacks->log(callbacks->environment, name, 3, "logStatusError", "wrong GUID %s", guid);
    return NULL;
  }
#ifdef OWN_MEMORY
  Model *m = calloc(1, sizeof(Model));
#else
  Model *m = callbacks->allocate(1, sizeof(Model));
#endif
  if (!m) return NULL;
  m->debug = logging;
  m->callbacks = callbacks;
  defaults(m);
  snprintf(m->name, sizeof m->name, "%s", name);
  REPORT("instantiated");
  at("instantiation");
  m->thread = pthread_self();
#ifdef READS /* its gain, in this folder */
  char path[1024];
  snprintf(path, sizeof path, "%s/gain.txt", READS);
  FILE *file = fopen(path, "r");
  if (!file) {
    callbacks->log(callbacks->environment, name, 3, "logStatusError", "no file %s", path);
    return NULL;
  }
  fscanf(file, "%lf", &m->r[1]);
  fclose(file);
#endif
#ifdef LEAVES_A_THREAD
  pthread_t thread;
  pthread_create(&thread, NULL, go_on, NULL);
  pthread_detach(thread);
#endif
#ifdef LOGS_LATE
  pthread_t logging_late;
  if (!first) pthread_create(&logging_late, NULL, log_late, NULL);
  if (!first) first = callbacks;
#endif
  return m;
}

#ifdef OWN_MEMORY
void fmi2FreeInstance(Component c) { free(c); }
#else
void fmi2FreeInstance(Component c) {
  Model *m = c;
  REPORT("freed");
  at("end");
#ifdef LOGS_LATE
  if (m->callbacks != first) /* so the first is freed */
    for (wanted_logs++; made_logs < wanted_logs;) usleep(100);
#endif
  m->callbacks->release(c);
}
#endif
Status fmi2SetDebugLogging(Component c, int on, size_t n, const char *const *categories) {
  Model *m = c;
#ifdef REFUSES_DEBUG
  return 3;
#endif
  m->debug = on;
  for (size_t k = 0; k < n; k++) SAY(0, categories[k], "category %zu of %zu", k + 1, n);
  return 0;
}
Status fmi2SetupExperiment(Component c, int tol, double t, double start, int stop, double end) {
  ((Model *)c)->time = start;
  ((Model *)c)->stop = end;
#ifdef NEEDS_STOP
  if (!stop) return 3;
#endif
#ifdef FORGETS_IN_SETUP
  ((Model *)c)->r[1] = 1;
  ((Model *)c)->text[0] = 0;
#endif
#ifdef TELLS_TOLERANCE
  ((Model *)c)->r[3] = tol ? t : -1;
#endif
  return WELL;
}
Status fmi2EnterInitializationMode(Component c) {
  ((Model *)c)->mode = 1;
#ifdef FORGETS_IN_ENTER
  ((Model *)c)->r[1] = 1;
#endif
#if defined MODEL_MASS
  ((Model *)c)->x = ((Model *)c)->i[0];
#elif defined MODEL_INERTIA
  ((Model *)c)->x = ((Model *)c)->r[3] == 1e9 ? 1 : ((Model *)c)->r[3];
#endif
#ifdef MODEL_INTEGRATOR
  ((Model *)c)->r[2] = ((Model *)c)->r[3] == 1e9 ? 0 : ((Model *)c)->r[3];
#endif
  return WELL;
}
Status fmi2ExitInitializationMode(Component c) {
  Model *m = c;
  m->mode = 2;
#ifdef FORGETS_IN_EXIT
  m->r[1] = 1;
#endif
  REPORT("initialized");
  at("initialization");
  return WELL;
}
#ifndef LACKS_OPTIONAL
Status fmi2Terminate(Component c) {
  Model *m = c;
  REPORT("terminated");
  at("termination");
#ifdef TERMINATE_FAILS
  return 3;
#endif
  return 0;
}
#endif
Status fmi2Reset(Component c) {
  Model *m = c, fresh = {.callbacks = m->callbacks, .debug = m->debug};
  memcpy(fresh.name, m->name, sizeof fresh.name);
  *m = fresh;
  defaults(m);
  return 0;
}

#ifdef IGNORES_K
#define IGNORED(NAME, REF) (NAME[0] == 'R' && (REF) == 1)
#else
#define IGNORED(NAME, REF) 0
#endif
#ifdef HIGH_REFERENCES /* only their lowest bits count */
#define PLACE(REF) ((REF) & 3)
#else
#define PLACE(REF) (REF)
#endif
#ifdef REFUSES_NOTHING /* a call with no variables is an error */
#define CHECKED(N) \
  if ((N) == 0) return 3
#else
#define CHECKED(N)
#endif
#ifdef SETS_ONLY_IN /* the only mode up to the end of initialization in which values are accepted */
#define SETTABLE \
  if (m->mode < 2 && m->mode != SETS_ONLY_IN) return 3
#else
#define SETTABLE
#endif
#ifdef READS_ONLY_AFTER /* initialization mode; until then it returns this */
#define READABLE \
  if (m->mode < 2) return READS_ONLY_AFTER
#else
#define READABLE
#endif
#define TRUTH_Real 1
#define TRUTH_Integer 1
#ifdef TRUE_IS_MINUS_ONE
#define TRUTH_Boolean -1
#else
#define TRUTH_Boolean 1
#endif
#define GET(NAME, TYPE, FIELD)                                                    \
  Status fmi2Get##NAME(Component c, const Ref *refs, size_t n, TYPE *values) {    \
    Model *m = c;                                                                 \
    CHECKED(n);                                                                   \
    READABLE;                                                                     \
    REPORT("get " #NAME);                                                           \
    outputs(m);                                                                   \
    for (size_t k = 0; k < n; k++) values[k] = TRUTH_##NAME * m->FIELD[PLACE(refs[k])]; \
    return WELL;                                                                  \
  }
#define SET(NAME, TYPE, FIELD)                                                    \
  Status fmi2Set##NAME(Component c, const Ref *refs, size_t n, const TYPE *values) { \
    Model *m = c;                                                                 \
    CHECKED(n);                                                                   \
    SETTABLE;                                                                     \
    REPORT("set " #NAME);                                                           \
    for (size_t k = 0; k < n; k++)                                                \
      if (!IGNORED(#NAME, refs[k])) m->FIELD[PLACE(refs[k])] = values[k];         \
    m->slope = 0;                                                                 \
    return WELL;                                                                     \
  }
GET(Real, double, r)
SET(Real, double, r)
#ifndef LACKS_OPTIONAL
GET(Integer, int, i)
SET(Integer, int, i)
GET(Boolean, int, b)
SET(Boolean, int, b)
#endif
Status fmi2GetString(Component c, const Ref *refs, size_t n, const char **values) {
#ifdef HIDES_STRINGS
  return 3;
#endif
#if defined STRING_IS_NULL
#define TEXT NULL
#elif defined STRING_IS_LATIN_1
#define TEXT "caf\xe9"
#elif defined STRING_IS_ONE
#define TEXT ((const char *)1)
#else
#define TEXT ((Model *)c)->text
#endif
  for (size_t k = 0; k < n; k++) values[k] = TEXT;
  return 0;
}
Status fmi2SetString(Component c, const Ref *refs, size_t n, const char *const *values) {
  Model *m = c;
  snprintf(m->text, sizeof m->text, "%s", values[0]);
  m->r[1] = strlen(m->text);
  return 0;
}

#ifdef PRINTF
/* Every conversion, flag, width, precision and length of C11, against vsnprintf. */
static void formats(Model *m) {
  int dummy;
  char expected[4000];
#define BOTH(...) (snprintf(expected, sizeof expected, __VA_ARGS__), SAY(0, "expected", "%s", expected), SAY(0, "rendered", __VA_ARGS__))
  BOTH("%d %i %u %o %x %X", -1, 2, 3u, 8u, 255u, 255u);
  BOTH("[%5d|%-5d|%05d|%+d|% d|%.3d|%#x|%#o]", 42, 42, 42, 42, 42, 42, 42, 8);
  BOTH("%hhd %hd %ld %lld %zu %jd %td", (signed char)-3, (short)-4, -5L, -6LL, (size_t)7, (intmax_t)8, (ptrdiff_t)9);
  BOTH("%hhu %hu %lu %llx", (unsigned char)250, (unsigned short)65000, 1UL << 63, ~0ULL);
  BOTH("%f %e %g %a %F %E %G %A", 1.5, 1.5e10, 1.5e-7, 1.0, -0.5, 2.5, 1e300, 0.1);
  BOTH("%.0f %.15g %10.3f %-10.2e| %+g %#g", 2.5, 0.1, 3.14159, 31415.9, 1.0, 1.0);
  BOTH("%*d|%-*d|%.*f|%*.*f", 6, 42, 6, 42, 2, 3.14159, 8, 1, 2.71828);
  BOTH("%*d|%.*s", -6, 42, -1, "all");
  BOTH("%s|%10s|%-10s|%.2s|%c|%5c|%%", "text", "right", "left", "cut", 'x', 'y');
  BOTH("%Lf %Lg %d", 1.25L, -2.5e100L, 7);
  BOTH("%d %d %d %d %d %d %d %g %s", 1, 2, 3, 4, 5, 6, 7, 0.5, "stack");
  BOTH("%g %g %g %g %g %g %g %g %g %g", 1., 2., 3., 4., 5., 6., 7., 8., 9., 10.);
  BOTH("%f %f", 1e308, -1.0 / 0.0);
  SAY(0, "null", "%s and %d", (char *)NULL, 5);
  SAY(0, "count", "a%nb %d", &dummy, 5);
  SAY(0, "wild", "50% solved, %s", (char *)8);
  SAY(0, "unknown", "%d %y %d", 5, 6);
  SAY(0, "end", "100%");
  char *long_text = malloc(100001);
  memset(long_text, 'x', 100000);
  long_text[100000] = 0;
  SAY(0, "long", "%s", long_text);
  SAY(0, "wide", "%*d", 2000000000, 1);
  free(long_text);
  m->callbacks->log(m->callbacks->environment, NULL, 77, NULL, NULL);
}
#endif

#if defined TANGENT_ERROR || defined TANGENT_NAN
Status fmi2GetDirectionalDerivative(Component c, const Ref *unknown, size_t n, const Ref *known,
                                    size_t m, const double *seed, double *result) {
#ifdef TANGENT_ERROR
  return 3;
#endif
  for (size_t k = 0; k < n; k++) result[k] = 0.0 / 0.0;
  return 0;
}
#endif

#ifdef PENDING
static void *work(void *argument) {
  usleep(30000);
  ((Model *)argument)->pending = 0;
  return NULL;
}
Status fmi2GetStatus(Component c, int kind, Status *status) {
  *status = __atomic_load_n(&((Model *)c)->pending, __ATOMIC_SEQ_CST) ? 5 : 0;
  return kind != 0;
}
#endif

#ifdef MODEL_NOSY
static const char *written(const char *folder) {
  char path[512];
  snprintf(path, sizeof path, "%s/nosy.txt", getenv(folder));
  const int file = open(path, O_CREAT | O_WRONLY, 0600);
  if (file < 0) return strerror(errno);
  close(file);
  return "done";
}
static const char *dialled(int port) {
  struct sockaddr_in to = {.sin_family = AF_INET, .sin_port = htons(port)};
  const int line = socket(AF_INET, SOCK_STREAM, 0);
  inet_pton(AF_INET, "127.0.0.1", &to.sin_addr);
  const int failed = connect(line, (struct sockaddr *)&to, sizeof to);
  const char *outcome = failed ? strerror(errno) : "done";
  close(line);
  return outcome;
}
static void nose_about(Model *m) {
  SAY(0, "logAll", "home: %s; network: %s; own folder: %s", written("HOME"),
      dialled((int)m->r[1]), written("TMPDIR"));
}
#endif

Status fmi2DoStep(Component c, double t, double h, int no_set) {
  Model *m = c;
  if (t - m->time > 1e-9 || m->time - t > 1e-9 || h <= 0) return 3;
  if (!m->first_step) m->first_step = h;
#ifdef THIRTIETHS /* no rounding of any instant is accepted */
  if (t != m->steps / 30.0 || h != 1 / 30.0) return 3;
#endif
#ifdef EQUAL_STEPS
  if (h != m->first_step) return 3;
#endif
#ifdef ENDS_AT_STOP /* to the last bit */
  if (t + h > m->stop) return 3;
#endif
#ifdef ONE_THREAD /* makes all calls from start to end */
  if (!pthread_equal(m->thread, pthread_self())) return 3;
#endif
#ifdef PRINTS
  puts("a line on standard output");
  fflush(stdout);
#endif
#ifdef DEEP_STACK
  volatile char deep[6 << 20];
  for (size_t k = 0; k < sizeof deep; k += 4096) deep[k] = 1;
#endif
#ifdef PRINTF
  if (!m->steps) formats(m);
#endif
#ifdef PENDING
  pthread_t thread;
  m->pending = 1;
  pthread_create(&thread, NULL, work, m);
  pthread_setname_np(thread, "works");
  pthread_detach(thread);
#endif
#ifdef LOGS_ONE /* addresses where there is nothing */
  SAY(0, (const char *)1, (const char *)1, 5);
#endif
#ifdef CALLS_STEP_FINISHED
  ((void (*)(void *, Status))m->callbacks->step_finished)(m->callbacks->environment, 0);
#endif
  if (m->debug) SAY(0, "logAll", "step to %g s", t + h);
  m->steps++;
#ifdef MODEL_PICKY
  m->ended = m->i[0] == 2 && t + h > m->r[3] * (1 + 1e-9);
  if (m->ended) {
    m->reached = m->r[3];
    return 2;
  }
  if (m->i[0] != 2 && h > m->r[3] * (1 + 1e-9)) { /* what it has computed by then is unusable */
    m->reached = m->i[0] ? t : t + m->r[3] / 2;
    m->r[2] += 1000;
    m->time += m->r[3] / 3;
    return 2;
  }
#endif
  m->time = t + h;
#ifdef TELLS_TIME
  snprintf(m->text, sizeof m->text, "%.1f s, \"said\"", m->time);
#endif
#if defined MODEL_INTEGRATOR || defined MODEL_PICKY
  m->r[2] += m->r[0] * h;
#elif defined MODEL_MASS || defined MODEL_INERTIA
  oscillate(m, h);
#endif
  if (m->slope) m->r[0] += m->slope * h; /* -0.0 + 0.0 would be 0.0 */
#ifdef MODEL_COUNTER
  if (m->steps == 2 && m->text[0])
    m->callbacks->log(m->callbacks->environment, m->name, 1, "logAll", "%s", m->text);
#endif
#ifdef ATTACK
#ifndef ATTACK_AT
#define ATTACK_AT 3
#endif
  if (m->steps == ATTACK_AT) attack(m);
#endif
  if (m->steps == 3) at("step");
#ifdef ABORTS
  if (m->steps == 6) abort();
#endif
#ifdef SPINS
  if (m->steps == 6)
    for (;;) __asm__ volatile("");
#endif
#ifdef FATAL
  if (m->steps == 6) return 4;
#endif
#ifdef FIRST_INCARNATION /* a statement */
  if (m->steps == 6 && is_first_incarnation()) FIRST_INCARNATION;
#endif
#ifdef MODEL_FAILING
  if (m->time > m->r[3]) {
    m->callbacks->log(m->callbacks->environment, m->name, 3, "logStatusError", "%s",
                      "the tank is empty");
    return 3;
  }
#endif
#ifdef MODEL_NOSY
  if (m->steps == 1) nose_about(m);
#endif
#ifdef MODEL_LOGGING
  if (m->steps == 3) {
    void *memory = m->callbacks->allocate(1000, 8);
    m->callbacks->log(m->callbacks->environment, m->name, 1, "logAll", "step %d of %s", m->steps,
                      m->name);
    m->callbacks->log(m->callbacks->environment, m->name, 1, "logAll", "level %f", 0.5);
    m->callbacks->log(m->callbacks->environment, m->name, 1, "logAll", "at step %d", m->steps);
    m->callbacks->release(memory);
    return 4;
  }
#endif
#ifdef PENDING
  return 5;
#endif
  return WELL;
}

#ifndef LACKS_OPTIONAL
Status fmi2GetRealStatus(Component c, int kind, double *value) {
  *value = ((Model *)c)->reached;
  return kind == 2 ? 0 : 2;
}
Status fmi2GetBooleanStatus(Component c, int kind, int *value) {
  *value = kind == 3 && ((Model *)c)->ended;
  return 0;
}
Status fmi2SetRealInputDerivatives(Component c, const Ref *refs, size_t n, const int *orders,
                                   const double *values) {
  for (size_t k = 0; k < n; k++) {
    if (refs[k] != 0 || orders[k] != 1) return 3;
    ((Model *)c)->slope = values[k];
  }
  return 0;
}
Status fmi2GetRealOutputDerivatives(Component c, const Ref *refs, size_t n, const int *orders,
                                    double *values) {
  Model *m = c;
  for (size_t k = 0; k < n; k++) {
    if (refs[k] != 2 || orders[k] != 1) return 3;
#ifdef MODEL_INERTIA
    values[k] = m->slope - m->r[1] * m->v;
#else
    values[k] = m->v;
#endif
  }
  return 0;
}
#if !defined TANGENT_ERROR && !defined TANGENT_NAN && !defined TANGENT_MISSING
Status fmi2GetDirectionalDerivative(Component c, const Ref *unknowns, size_t n, const Ref *knowns,
                                    size_t m, const double *seed, double *result) {
  for (size_t k = 0; k < n; k++) {
    result[k] = 0;
    for (size_t j = 0; j < m; j++)
      if (unknowns[k] == 2 && knowns[j] == 0)
#ifdef MODEL_INERTIA
        result[k] += seed[j];
#elif defined MODEL_CUBIC
        result[k] -= 3 * ((Model *)c)->r[1] * ((Model *)c)->r[0] * ((Model *)c)->r[0] * seed[j];
#else
        result[k] += ((Model *)c)->r[1] * seed[j];
#endif
  }
  return 0;
}
#endif

Status fmi2GetFMUstate(Component c, void **state) {
  Model *m = c;
#ifdef STATE_NULL
  return 0;
#endif
#ifdef STATE_ERROR
  return 3;
#endif
  if (!*state) *state = m->callbacks->allocate(1, sizeof(Model));
  memcpy(*state, m, sizeof(Model));
  return 0;
}
Status fmi2SetFMUstate(Component c, void *state) {
  memcpy(c, state, sizeof(Model));
  return 0;
}
Status fmi2FreeFMUstate(Component c, void **state) {
  ((Model *)c)->callbacks->release(*state);
  *state = NULL;
  return 0;
}
Status fmi2SerializedFMUstateSize(Component c, void *state, size_t *size) {
  *size = sizeof(Model);
  return 0;
}
Status fmi2SerializeFMUstate(Component c, void *state, unsigned char *bytes, size_t size) {
  if (size != sizeof(Model)) return 3;
  memcpy(bytes, state, size);
  memset(bytes, 0, sizeof(void *)); /* the callbacks are the process's */
  return 0;
}
Status fmi2DeSerializeFMUstate(Component c, const unsigned char *bytes, size_t size, void **state) {
  if (size != sizeof(Model)) return 3;
  if (!*state) *state = ((Model *)c)->callbacks->allocate(1, sizeof(Model));
  memcpy(*state, bytes, size);
  ((Model *)*state)->callbacks = ((Model *)c)->callbacks;
  return 0;
}
#endif

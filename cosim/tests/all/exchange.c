/* FMI 2.0 model exchange FMUs for tests; the descriptions are in models.rs. Written from the
 * standard, without its headers. Calls in the wrong mode return Error. */
#include <math.h>
#include <stddef.h>
#include <string.h>

typedef void *Component;
typedef unsigned int Ref;
typedef int Status;
typedef struct {
  void *log;
  void *(*allocate)(size_t, size_t);
  void (*release)(void *);
  void *step_finished, *environment;
} Callbacks;
typedef struct {
  int again, terminate, nominals, values, next_defined;
  double next;
} EventInfo;

#ifndef NOMINAL
#define NOMINAL 1
#endif
#ifdef REVERSED /* the order of the states */
#define STATE(K) (2 * (n - 1 - (K)))
#else
#define STATE(K) (2 * (K))
#endif

enum { INSTANTIATED, INITIALIZING, EVENT, CONTINUOUS };
typedef struct {
  const Callbacks *callbacks;
  int mode;
  double time, next;
  double r[9]; /* 0 u, 1 k, 2 y, 3 x, 4 der(x), 5 v, 6 der(v), 7 s, 8 der(s) */
  int i[4];    /* 0 m, 1 n */
  int b[4];
} Model;

static void derive(Model *m) {
  double *r = m->r;
#if defined MODEL_BALL
  r[4] = r[5];
  r[6] = -9.81;
#elif defined MODEL_OSCILLATOR
  r[4] = r[5];
  r[6] = -400 * r[3];
  r[8] = -500 * (r[7] - sin(m->time)) + cos(m->time);
#elif defined MODEL_SAWTOOTH
  r[4] = 1;
#elif defined MODEL_LAG
  r[4] = r[0] - r[1] * r[3];
#endif
  r[2] = r[3];
}

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
Component fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                          const Callbacks *callbacks, int visible, int logging) {
  if (strcmp(guid, "{test}") || type != 0) return NULL;
  Model *m = callbacks->allocate(1, sizeof(Model));
  m->callbacks = callbacks;
  m->r[1] = 0.5;
  m->r[3] = X0;
  return m;
}
void fmi2FreeInstance(Component c) { ((Model *)c)->callbacks->release(c); }
Status fmi2SetupExperiment(Component c, int tol, double t, double start, int stop, double end) {
  ((Model *)c)->time = start;
  return 0;
}
#define MODE(FROM, TO)                       \
  Model *m = c;                              \
  if (m->mode != FROM) return 3;             \
  m->mode = TO;                              \
  return 0;
Status fmi2EnterInitializationMode(Component c) { MODE(INSTANTIATED, INITIALIZING) }
Status fmi2ExitInitializationMode(Component c) {
#ifdef FORGETS_IN_EXIT
  ((Model *)c)->r[1] = 0.5;
#endif
  MODE(INITIALIZING, EVENT)
}
Status fmi2EnterEventMode(Component c) { MODE(CONTINUOUS, EVENT) }
Status fmi2EnterContinuousTimeMode(Component c) { MODE(EVENT, CONTINUOUS) }
Status fmi2Terminate(Component c) { return 0; }

#define GET(NAME, TYPE, FIELD)                                                 \
  Status fmi2Get##NAME(Component c, const Ref *refs, size_t n, TYPE *values) { \
    Model *m = c;                                                              \
    derive(m);                                                                 \
    for (size_t k = 0; k < n; k++) values[k] = m->FIELD[refs[k]];              \
    return 0;                                                                  \
  }
#define SET(NAME, TYPE, FIELD, FORBIDDEN)                                         \
  Status fmi2Set##NAME(Component c, const Ref *refs, size_t n, const TYPE *values) { \
    Model *m = c;                                                                 \
    if (m->mode == FORBIDDEN) return 3;                                           \
    for (size_t k = 0; k < n; k++) m->FIELD[refs[k]] = values[k];                 \
    return 0;                                                                     \
  }
GET(Real, double, r)
SET(Real, double, r, 99)
GET(Integer, int, i)
SET(Integer, int, i, CONTINUOUS)
GET(Boolean, int, b)
SET(Boolean, int, b, CONTINUOUS)
#ifdef COUNTS_TEXTS /* how often it is set during the run */
Status fmi2SetString(Component c, const Ref *r, size_t n, const char *const *v) {
  Model *m = c;
  if (m->mode == CONTINUOUS) return 3;
  m->i[2] += m->mode == EVENT;
  return 0;
}
#else
Status fmi2SetString(Component c, const Ref *r, size_t n, const char *const *v) { return 0; }
#endif

Status fmi2NewDiscreteStates(Component c, EventInfo *info) {
  Model *m = c;
  double *r = m->r;
  if (m->mode != EVENT) return 3;
#ifdef STORM
  info->again = 1;
#endif
#if defined MODEL_BALL
  if (r[3] <= 0 && r[5] < 0) { /* the height stays 0: its indicator stays in its domain */
    r[3] = 0;
    r[5] *= -r[1];
    m->i[1]++;
    info->values = 1;
#ifdef SAYS_IT_ONCE /* and no longer in the last iteration */
    info->again = 1;
#endif
  }
#elif defined MODEL_TICKER
  info->next_defined = 1;
  if (m->time >= m->next) { /* an event that comes early or twice is not counted */
    m->next = ++m->i[1] * r[1];
    info->again = 1;
  }
  info->next = m->next;
#ifdef LATE
  info->next = m->time - 1;
#elif defined UNDEFINED
  info->next = 0.0 / 0.0;
#endif
  m->b[1] = m->b[0] + m->i[0];
#elif defined MODEL_SAWTOOTH
  if (r[3] >= 1) {
    r[3] -= 1;
    m->i[1]++;
    info->values = 1;
  }
#elif defined MODEL_LAG
  m->i[1]++; /* counts calls: at the start, and when an input moves the indicator */
#endif
  return 0;
}
#ifndef LACKS_OPTIONAL
Status fmi2CompletedIntegratorStep(Component c, int no_set, int *event, int *terminate) {
#ifdef MODEL_SAWTOOTH
  const Model *m = c;
  *event = m->r[3] >= 1;
  *terminate = m->i[0] && m->i[1] >= m->i[0];
#endif
  return 0;
}
#endif
Status fmi2SetTime(Component c, double time) {
  ((Model *)c)->time = time;
  return 0;
}
Status fmi2SetContinuousStates(Component c, const double *x, size_t n) {
  for (size_t k = 0; k < n; k++) ((Model *)c)->r[3 + STATE(k)] = x[k];
  return 0;
}
Status fmi2GetContinuousStates(Component c, double *x, size_t n) {
  for (size_t k = 0; k < n; k++) x[k] = ((Model *)c)->r[3 + STATE(k)];
  return 0;
}
Status fmi2GetDerivatives(Component c, double *x, size_t n) {
  derive(c);
  for (size_t k = 0; k < n; k++) x[k] = ((Model *)c)->r[4 + STATE(k)];
  return 0;
}
Status fmi2GetNominalsOfContinuousStates(Component c, double *x, size_t n) {
  for (size_t k = 0; k < n; k++) x[k] = NOMINAL;
  return 0;
}
Status fmi2GetEventIndicators(Component c, double *z, size_t n) {
#ifdef MODEL_BALL
  z[0] = ((Model *)c)->r[3];
#else
  for (size_t k = 0; k < n; k++) z[k] = ((Model *)c)->r[0] - 0.5;
#endif
  return 0;
}
Status fmi2GetFMUstate(Component c, void **state) {
  Model *m = c;
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

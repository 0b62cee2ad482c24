/* FMI 2.0 co-simulation FMUs for tests, not written in Rust. -DMODEL_x chooses the behaviour;
 * the descriptions are in models.rs. Written from the standard, without its headers. */
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

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

typedef struct {
  const Callbacks *callbacks;
  double r[4];  /* 0 u, 1 k, 2 y, 3 second parameter */
  int i[4], b[4];
  double time;
  int steps;
  int initialized;
  char name[64], text[64];
} Model;

static void outputs(Model *m) {
#if defined MODEL_GAIN || defined MODEL_FAILING || defined MODEL_LOGGING
  m->r[2] = m->r[1] * m->r[0];
#elif defined MODEL_AFFINE
  m->r[2] = m->r[1] * m->r[0] + m->time;
#elif defined MODEL_CUBIC
  m->r[2] = m->time - m->r[1] * m->r[0] * m->r[0] * m->r[0];
#elif defined MODEL_CLOCK
  m->r[2] = m->time;
#elif defined MODEL_COUNTER
  m->r[2] = m->steps;
  m->i[1] = m->steps + m->i[0];
  m->b[1] = !m->b[0];
#endif
}

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

Component fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                          const Callbacks *callbacks, int visible, int logging) {
  if (strcmp(guid, "{test}") || type != 1 || strncmp(resources, "file:///", 8)) {
    callbacks->log(callbacks->environment, name, 3, "logStatusError", "wrong GUID %s", guid);
    return NULL;
  }
  Model *m = callbacks->allocate(1, sizeof(Model));
  if (!m) return NULL;
  m->callbacks = callbacks;
  m->r[1] = 1;
  m->r[3] = 1e9;
  snprintf(m->name, sizeof m->name, "%s", name);
  return m;
}

void fmi2FreeInstance(Component c) { ((Model *)c)->callbacks->release(c); }
Status fmi2SetupExperiment(Component c, int tol, double t, double start, int stop, double end) {
  ((Model *)c)->time = start;
  return 0;
}
Status fmi2EnterInitializationMode(Component c) {
#ifdef MODEL_INTEGRATOR
  ((Model *)c)->r[2] = ((Model *)c)->r[3] == 1e9 ? 0 : ((Model *)c)->r[3];
#endif
  return 0;
}
Status fmi2ExitInitializationMode(Component c) {
  ((Model *)c)->initialized = 1;
  return 0;
}
Status fmi2Terminate(Component c) { return 0; }
Status fmi2Reset(Component c) { return 0; }

#define GET(NAME, TYPE, FIELD)                                                    \
  Status fmi2Get##NAME(Component c, const Ref *refs, size_t n, TYPE *values) {    \
    Model *m = c;                                                                 \
    outputs(m);                                                                   \
    for (size_t k = 0; k < n; k++) values[k] = m->FIELD[refs[k]];                 \
    return 0;                                                                     \
  }
#define SET(NAME, TYPE, FIELD)                                                    \
  Status fmi2Set##NAME(Component c, const Ref *refs, size_t n, const TYPE *values) { \
    Model *m = c;                                                                 \
    for (size_t k = 0; k < n; k++) m->FIELD[refs[k]] = values[k];                 \
    return 0;                                                                     \
  }
GET(Real, double, r)
SET(Real, double, r)
GET(Integer, int, i)
SET(Integer, int, i)
GET(Boolean, int, b)
SET(Boolean, int, b)
Status fmi2SetString(Component c, const Ref *refs, size_t n, const char *const *values) {
  Model *m = c;
  snprintf(m->text, sizeof m->text, "%s", values[0]);
  m->r[1] = strlen(m->text);
  return 0;
}

Status fmi2DoStep(Component c, double t, double h, int no_set) {
  Model *m = c;
  if (t - m->time > 1e-9 || m->time - t > 1e-9 || h <= 0) return 3;
  m->steps++;
  m->time = t + h;
#ifdef MODEL_INTEGRATOR
  m->r[2] += m->r[0] * h;
#endif
#ifdef MODEL_COUNTER
  if (m->steps == 2 && m->text[0])
    m->callbacks->log(m->callbacks->environment, m->name, 1, "logAll", "%s", m->text);
#endif
#ifdef MODEL_FAILING
  if (m->time > m->r[3]) {
    m->callbacks->log(m->callbacks->environment, m->name, 3, "logStatusError", "%s",
                      "the tank is empty");
    return 3;
  }
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

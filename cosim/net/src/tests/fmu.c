/* An FMI 2.0 FMU with a state, noise whose generator is part of the state, a held input v, and an input u that is fed
 * through when `through` is 1. `chaos` 1 adds something that no state contains. Written from the standard. */
#include <stddef.h>
#include <string.h>

typedef void *Component;
typedef unsigned Ref;
typedef int Status;
typedef struct {
  void (*log)(void *, const char *, Status, const char *, const char *, ...);
  void *(*allocate)(size_t, size_t);
  void (*release)(void *);
} Callbacks;
typedef struct {
  double r[8]; /* 0 u, 1 v, 2 y, 3 k, 4 through, 5 x, 6 der(x), 7 chaos */
  unsigned long long noise;
} Data;
typedef struct {
  const Callbacks *callbacks;
  Data data;
} Model;
typedef struct {
  int again, terminate, nominals, values, next_defined;
  double next;
} EventInfo;

static unsigned long long calls; /* of all instances: no state contains it */

static void derive(double *r) {
  r[2] = r[5] + r[4] * r[3] * r[0];
  r[6] = 0.3 * r[1] + 0.3 * r[0] - 0.5 * r[5] - 0.1 * r[5] * r[5] * r[5] + 0.1;
}

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
Component fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const Callbacks *callbacks,
                          int visible, int logging) {
  Model *m = callbacks->allocate(1, sizeof(Model));
  if (!m) return NULL;
  m->callbacks = callbacks;
  m->data.noise = 42;
  m->data.r[3] = 0.4;
  m->data.r[4] = !strcmp(guid, "Through");
  m->data.r[5] = 0.1;
  m->data.r[7] = !strcmp(guid, "Chaos");
  return m;
}
void fmi2FreeInstance(Component c) { ((Model *)c)->callbacks->release(c); }
Status fmi2SetDebugLogging(Component c, int on, size_t n, const char *const *categories) { return 0; }
Status fmi2SetupExperiment(Component c, int tol, double t, double start, int stop, double end) { return 0; }
Status fmi2EnterInitializationMode(Component c) { return 0; }
Status fmi2ExitInitializationMode(Component c) { return 0; }
Status fmi2Terminate(Component c) { return 0; }
Status fmi2Reset(Component c) { return 0; }
Status fmi2GetReal(Component c, const Ref *refs, size_t n, double *values) {
  double *r = ((Model *)c)->data.r;
  derive(r);
  for (size_t k = 0; k < n; k++) values[k] = r[refs[k]];
  return 0;
}
Status fmi2SetReal(Component c, const Ref *refs, size_t n, const double *values) {
  for (size_t k = 0; k < n; k++) ((Model *)c)->data.r[refs[k]] = values[k];
  return 0;
}
#define NOTHING(NAME, TYPE)                                                              \
  Status fmi2Get##NAME(Component c, const Ref *r, size_t n, TYPE *v) { return 0; }       \
  Status fmi2Set##NAME(Component c, const Ref *r, size_t n, const TYPE *v) { return 0; }
NOTHING(Integer, int)
NOTHING(Boolean, int)
NOTHING(String, char *)

Status fmi2DoStep(Component c, double t, double h, int no_set) {
  Data *d = &((Model *)c)->data;
  d->noise = d->noise * 6364136223846793005ULL + 1442695040888963407ULL;
  derive(d->r);
  d->r[5] += h * d->r[6] + 1e-3 * ((double)(d->noise >> 11) / 9007199254740992.0 - 0.5);
  if (d->r[7]) d->r[5] += 1e-9 * ++calls;
  return 0;
}
Status fmi2CancelStep(Component c) { return 3; }

Status fmi2EnterEventMode(Component c) { return 0; }
Status fmi2EnterContinuousTimeMode(Component c) { return 0; }
Status fmi2NewDiscreteStates(Component c, EventInfo *info) {
  memset(info, 0, sizeof *info);
  return 0;
}
Status fmi2CompletedIntegratorStep(Component c, int no_set, int *event, int *terminate) {
  *event = *terminate = 0;
  return 0;
}
Status fmi2SetTime(Component c, double time) { return 0; }
Status fmi2SetContinuousStates(Component c, const double *x, size_t n) {
  ((Model *)c)->data.r[5] = x[0];
  return 0;
}
Status fmi2GetContinuousStates(Component c, double *x, size_t n) {
  x[0] = ((Model *)c)->data.r[5];
  return 0;
}
Status fmi2GetDerivatives(Component c, double *x, size_t n) {
  derive(((Model *)c)->data.r);
  x[0] = ((Model *)c)->data.r[6];
  return 0;
}
Status fmi2GetNominalsOfContinuousStates(Component c, double *x, size_t n) {
  x[0] = 1;
  return 0;
}
Status fmi2GetEventIndicators(Component c, double *z, size_t n) { return 0; }

Status fmi2GetFMUstate(Component c, void **state) {
  if (!*state) *state = ((Model *)c)->callbacks->allocate(1, sizeof(Data));
  memcpy(*state, &((Model *)c)->data, sizeof(Data));
  return 0;
}
Status fmi2SetFMUstate(Component c, void *state) {
  memcpy(&((Model *)c)->data, state, sizeof(Data));
  return 0;
}
Status fmi2FreeFMUstate(Component c, void **state) {
  ((Model *)c)->callbacks->release(*state);
  *state = NULL;
  return 0;
}
Status fmi2SerializedFMUstateSize(Component c, void *state, size_t *size) {
  *size = sizeof(Data);
  return 0;
}
Status fmi2SerializeFMUstate(Component c, void *state, char *bytes, size_t size) {
  memcpy(bytes, state, sizeof(Data));
  return 0;
}
Status fmi2DeSerializeFMUstate(Component c, const char *bytes, size_t size, void **state) {
  if (!*state) *state = ((Model *)c)->callbacks->allocate(1, sizeof(Data));
  memcpy(*state, bytes, sizeof(Data));
  return 0;
}

/* A small co-simulation FMU with every function of that interface, for comparing masters:
 *   y = k u + b t,   x' = a x + u by Euler's method, x(start) = x0;   element.xml describes it.
 * Written from the standard, without its headers. */
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef void *Component;
typedef unsigned int Ref;
typedef int Status;
enum { OK = 0, DISCARD = 2, ERROR = 3 };
enum { U, K, Y, B, A, X, X0, REALS };

typedef struct {
  double real[REALS];
  double time;
  int steps, moving;
  char label[64];
} Element;

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
Status fmi2SetDebugLogging(Component c, int on, size_t n, const char *const *categories) { return OK; }

Component fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                          const void *callbacks, int visible, int logging) {
  if (type != 1 || strcmp(guid, "{element}")) return NULL;
  Element *e = calloc(1, sizeof *e);
  if (e) e->real[K] = 1;
  return e;
}
void fmi2FreeInstance(Component c) { free(c); }
Status fmi2SetupExperiment(Component c, int tolerant, double tolerance, double start, int stops, double stop) {
  ((Element *)c)->time = start;
  return OK;
}
Status fmi2EnterInitializationMode(Component c) {
  Element *e = c;
  e->real[X] = e->real[X0];
  return OK;
}
Status fmi2ExitInitializationMode(Component c) { return OK; }
Status fmi2Terminate(Component c) { return OK; }
Status fmi2Reset(Component c) {
  memset(c, 0, sizeof(Element));
  ((Element *)c)->real[K] = 1;
  return OK;
}

Status fmi2GetReal(Component c, const Ref *refs, size_t n, double *values) {
  Element *e = c;
  e->real[Y] = e->real[K] * e->real[U] + e->real[B] * e->time;
  for (size_t i = 0; i < n; i++) {
    if (refs[i] >= REALS) return ERROR;
    values[i] = e->real[refs[i]];
  }
  return OK;
}
Status fmi2SetReal(Component c, const Ref *refs, size_t n, const double *values) {
  Element *e = c;
  for (size_t i = 0; i < n; i++) {
    if (refs[i] >= REALS) return ERROR;
    e->real[refs[i]] = values[i];
  }
  e->moving = e->real[U] != 0;
  return OK;
}
Status fmi2GetInteger(Component c, const Ref *refs, size_t n, int *values) {
  for (size_t i = 0; i < n; i++) values[i] = ((Element *)c)->steps;
  return OK;
}
Status fmi2SetInteger(Component c, const Ref *refs, size_t n, const int *values) { return n ? ERROR : OK; }
Status fmi2GetBoolean(Component c, const Ref *refs, size_t n, int *values) {
  for (size_t i = 0; i < n; i++) values[i] = ((Element *)c)->moving;
  return OK;
}
Status fmi2SetBoolean(Component c, const Ref *refs, size_t n, const int *values) { return n ? ERROR : OK; }
Status fmi2GetString(Component c, const Ref *refs, size_t n, const char **values) {
  for (size_t i = 0; i < n; i++) values[i] = ((Element *)c)->label;
  return OK;
}
Status fmi2SetString(Component c, const Ref *refs, size_t n, const char *const *values) {
  if (n) snprintf(((Element *)c)->label, sizeof ((Element *)c)->label, "%s", values[0]);
  return OK;
}

Status fmi2DoStep(Component c, double t, double h, int no_set) {
  Element *e = c;
  e->real[X] += h * (e->real[A] * e->real[X] + e->real[U]);
  e->time = t + h;
  e->steps++;
  return OK;
}
Status fmi2CancelStep(Component c) { return ERROR; }

Status fmi2GetFMUstate(Component c, void **state) {
  if (!*state && !(*state = malloc(sizeof(Element)))) return ERROR;
  memcpy(*state, c, sizeof(Element));
  return OK;
}
Status fmi2SetFMUstate(Component c, void *state) {
  memcpy(c, state, sizeof(Element));
  return OK;
}
Status fmi2FreeFMUstate(Component c, void **state) {
  free(*state);
  *state = NULL;
  return OK;
}
Status fmi2SerializedFMUstateSize(Component c, void *state, size_t *size) {
  *size = sizeof(Element);
  return OK;
}
Status fmi2SerializeFMUstate(Component c, void *state, char *bytes, size_t size) {
  if (size != sizeof(Element)) return ERROR;
  memcpy(bytes, state, size);
  return OK;
}
Status fmi2DeSerializeFMUstate(Component c, const char *bytes, size_t size, void **state) {
  if (size != sizeof(Element) || !(*state = malloc(size))) return ERROR;
  memcpy(*state, bytes, size);
  return OK;
}
Status fmi2GetDirectionalDerivative(Component c, const Ref *unknowns, size_t u, const Ref *knowns, size_t k,
                                    const double *seed, double *result) { return ERROR; }
Status fmi2SetRealInputDerivatives(Component c, const Ref *refs, size_t n, const int *orders,
                                   const double *values) { return ERROR; }
Status fmi2GetRealOutputDerivatives(Component c, const Ref *refs, size_t n, const int *orders,
                                    double *values) { return ERROR; }
Status fmi2GetStatus(Component c, int kind, Status *value) { return DISCARD; }
Status fmi2GetRealStatus(Component c, int kind, double *value) { return DISCARD; }
Status fmi2GetIntegerStatus(Component c, int kind, int *value) { return DISCARD; }
Status fmi2GetBooleanStatus(Component c, int kind, int *value) { return DISCARD; }
Status fmi2GetStringStatus(Component c, int kind, const char **value) { return DISCARD; }

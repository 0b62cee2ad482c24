/* Steps FMI 2.0 libraries and writes down, bit for bit, all their results: outputs, saved states, log
 * texts. `cargo xtask platforms` compiles it for each platform and compares its output.
 *
 *     driver jobs.txt
 *
 * A line of jobs.txt: kind, library, identifier (GUID), plan, file to write; separated by tabs. It computes
 * nothing: all numbers come from the plans, so that no compiler can round them differently. */

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
#define OPEN(path) ((void *)LoadLibraryA(path))
#define FIND(library, name) ((void *)GetProcAddress((HMODULE)(library), name))
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW | RTLD_LOCAL)
#define FIND(library, name) dlsym(library, name)
#endif

typedef void *Component;
typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*step_finished)(void *, int);
    void *environment;
} Callbacks;
typedef struct {
    int new_discrete_states_needed, terminate, nominals_changed, values_changed, next_time_defined;
    double next_time;
} EventInfo;

/* The functions that are called, by their names without the prefix. */
#define FUNCTIONS(X) \
    X(Component, Instantiate, (const char *, int, const char *, const char *, const Callbacks *, int, int)) \
    X(void, FreeInstance, (Component)) \
    X(int, SetupExperiment, (Component, int, double, double, int, double)) \
    X(int, EnterInitializationMode, (Component)) \
    X(int, ExitInitializationMode, (Component)) \
    X(int, Terminate, (Component)) \
    X(int, Reset, (Component)) \
    X(int, GetReal, (Component, const uint32_t *, size_t, double *)) \
    X(int, GetInteger, (Component, const uint32_t *, size_t, int *)) \
    X(int, GetBoolean, (Component, const uint32_t *, size_t, int *)) \
    X(int, SetReal, (Component, const uint32_t *, size_t, const double *)) \
    X(int, SetString, (Component, const uint32_t *, size_t, const char *const *)) \
    X(int, DoStep, (Component, double, double, int)) \
    X(int, GetFMUstate, (Component, void **)) \
    X(int, SetFMUstate, (Component, void *)) \
    X(int, FreeFMUstate, (Component, void **)) \
    X(int, SerializedFMUstateSize, (Component, void *, size_t *)) \
    X(int, SerializeFMUstate, (Component, void *, char *, size_t)) \
    X(int, DeSerializeFMUstate, (Component, const char *, size_t, void **)) \
    X(int, NewDiscreteStates, (Component, EventInfo *)) \
    X(int, EnterContinuousTimeMode, (Component)) \
    X(int, SetTime, (Component, double)) \
    X(int, GetDerivatives, (Component, double *, size_t)) \
    X(int, GetEventIndicators, (Component, double *, size_t))

#define DECLARE(type, name, arguments) static type(*name) arguments;
FUNCTIONS(DECLARE)

static FILE *out;

static void fail(const char *what, const char *about) {
    fprintf(stderr, "error: %s: %s\n", what, about);
    exit(2);
}

static void load(const char *path) {
    void *library = OPEN(path);
    if (!library) {
        fail("the library cannot be loaded", path);
    }
#define RESOLVE(type, name, arguments) \
    if (!(name = (type(*) arguments)FIND(library, "fmi2" #name))) { \
        fail("the library lacks", "fmi2" #name); \
    }
    FUNCTIONS(RESOLVE)
}

/* A log text: `l`, status, category, text. */
static void logger(void *environment, const char *instance, int status, const char *category,
                   const char *format, ...) {
    char text[4096];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    (void)environment;
    fprintf(out, "l %d %s %s: %s\n", status, instance, category, text);
}

static const Callbacks callbacks = {logger, calloc, free, NULL, NULL};

static void hexadecimal(const unsigned char *bytes, size_t count) {
    static const char digits[] = "0123456789abcdef";
    for (size_t i = 0; i < count; i++) {
        putc(digits[bytes[i] >> 4], out);
        putc(digits[bytes[i] & 15], out);
    }
}

static void numbers(const double *values, size_t count) {
    for (size_t i = 0; i < count; i++) {
        putc(' ', out);
        hexadecimal((const unsigned char *)&values[i], sizeof values[i]);
    }
}

/* A component's variables, and its plan. */
typedef struct {
    uint32_t inputs, outputs, reals, integers, booleans, states, indicators, steps, saved_at, repeated;
    uint32_t *references; /* of inputs, outputs, Reals, Integers, Booleans, in this order */
    double *rows;         /* time, step, inputs; for each step */
} Plan;

static void *take(FILE *file, size_t size, size_t count, const char *path) {
    void *block = calloc(count ? count : 1, size);
    if (!block || fread(block, size, count, file) != count) {
        fail("the plan cannot be read", path);
    }
    return block;
}

static Plan plan(const char *path) {
    Plan p;
    FILE *file = fopen(path, "rb");
    if (!file || fread(&p, 4, 10, file) != 10) {
        fail("the plan cannot be read", path);
    }
    size_t references = (size_t)p.inputs + p.outputs + p.reals + p.integers + p.booleans;
    p.references = take(file, sizeof(uint32_t), references, path);
    p.rows = take(file, sizeof(double), (size_t)p.steps * (2 + p.inputs), path);
    fclose(file);
    return p;
}

static Component instantiate(const char *name, int kind, const char *guid, const char *resources) {
    Component instance = Instantiate(name, kind, guid, resources, &callbacks, 0, 1);
    if (!instance) {
        fail("the component cannot be instantiated", name);
    }
    return instance;
}

static int initialize(Component c) {
    int status = SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0);
    if (status <= 1) {
        status = EnterInitializationMode(c);
    }
    return status <= 1 ? ExitInitializationMode(c) : status;
}

/* Everything that can be read: `v`, statuses, values. */
static void everything(Component c, const Plan *p) {
    const uint32_t *at = p->references + p->inputs + p->outputs;
    double *reals = calloc(p->reals + 1, sizeof(double));
    int *others = calloc(p->integers + p->booleans + 1, sizeof(int));
    fprintf(out, "v %d", GetReal(c, at, p->reals, reals));
    numbers(reals, p->reals);
    at += p->reals;
    fprintf(out, " %d", GetInteger(c, at, p->integers, others));
    at += p->integers;
    fprintf(out, " %d", GetBoolean(c, at, p->booleans, others + p->integers));
    for (uint32_t i = 0; i < p->integers + p->booleans; i++) {
        fprintf(out, " %d", others[i]);
    }
    fputs("\n", out);
    free(reals);
    free(others);
}

/* The bytes of the present state: `b`, status, length, bytes. */
static char *saved(Component c, size_t *size) {
    void *state = NULL;
    int status = GetFMUstate(c, &state);
    if (status > 1 || SerializedFMUstateSize(c, state, size) > 1) {
        fail("the state cannot be saved", "");
    }
    char *bytes = calloc(*size + 1, 1);
    status = SerializeFMUstate(c, state, bytes, *size);
    fprintf(out, "b %d %lu ", status, (unsigned long)*size);
    hexadecimal((unsigned char *)bytes, *size);
    fputs("\n", out);
    FreeFMUstate(c, &state);
    return bytes;
}

/* One step: the mark, its number, statuses, outputs. */
static void step(Component c, const Plan *p, uint32_t k, char mark, double *outputs) {
    const double *row = p->rows + (size_t)k * (2 + p->inputs);
    int set = SetReal(c, p->references, p->inputs, row + 2);
    int done = DoStep(c, row[0], row[1], 1);
    int got = GetReal(c, p->references + p->inputs, p->outputs, outputs);
    fprintf(out, "%c %lu %d %d %d", mark, (unsigned long)k, set, done, got);
    numbers(outputs, p->outputs);
    fputs("\n", out);
}

static void co_simulation(const char *name, const char *guid, const Plan *p) {
    Component c = instantiate(name, 1, guid, "");
    double *outputs = calloc(p->outputs + 1, sizeof(double));
    fprintf(out, "i %d\n", initialize(c));
    everything(c, p);
    for (uint32_t k = 0; k < p->steps; k++) {
        if (k == p->saved_at) {
            size_t size;
            void *state = NULL;
            char *bytes = saved(c, &size);
            for (uint32_t ahead = k; ahead < k + p->repeated && ahead < p->steps; ahead++) {
                step(c, p, ahead, 'a', outputs);
            }
            int read = DeSerializeFMUstate(c, bytes, size, &state);
            int restored = SetFMUstate(c, state);
            fprintf(out, "r %d %d\n", read, restored);
            FreeFMUstate(c, &state);
            free(bytes);
        }
        step(c, p, k, 's', outputs);
        if (k % 100 == 99) {
            everything(c, p);
        }
    }
    size_t size;
    free(saved(c, &size));
    /* Calls that must be rejected, with a message. */
    uint32_t unknown = 0xffffffff;
    uint64_t bits = 0x7ff8000000000000;
    double nan;
    memcpy(&nan, &bits, sizeof nan);
    fprintf(out, "e %d\n", GetReal(c, &unknown, 1, outputs));
    fprintf(out, "e %d\n", p->inputs ? SetReal(c, p->references, 1, &nan) : 0);
    fprintf(out, "e %d\n", DoStep(c, 0.0, -1.0, 1));
    fprintf(out, "e %d\n", Reset(c));
    FreeInstance(c);
    free(outputs);
}

static void model_exchange(const char *name, const char *guid, const Plan *p) {
    Component c = instantiate(name, 0, guid, "");
    double *values = calloc(p->states + p->indicators + 1, sizeof(double));
    EventInfo info;
    fprintf(out, "i %d\n", initialize(c));
    for (int round = 0; round < 10; round++) {
        memset(&info, 0, sizeof info);
        fprintf(out, "n %d\n", NewDiscreteStates(c, &info));
        if (!info.new_discrete_states_needed) {
            break;
        }
    }
    fprintf(out, "c %d", EnterContinuousTimeMode(c));
    numbers(&info.next_time, info.next_time_defined ? 1 : 0);
    fputs("\n", out);
    for (uint32_t k = 0; k < p->steps; k++) {
        const double *row = p->rows + (size_t)k * (2 + p->inputs);
        if (info.next_time_defined && row[0] >= info.next_time) {
            break;
        }
        int time = SetTime(c, row[0]);
        int set = SetReal(c, p->references, p->inputs, row + 2);
        int derivatives = GetDerivatives(c, values, p->states);
        int indicators = GetEventIndicators(c, values + p->states, p->indicators);
        fprintf(out, "d %lu %d %d %d %d", (unsigned long)k, time, set, derivatives, indicators);
        numbers(values, p->states + p->indicators);
        fputs("\n", out);
    }
    fprintf(out, "t %d\n", Terminate(c));
    FreeInstance(c);
    free(values);
}

/* A panic in one instance: it ends, the other one and this program continue. The plan's first input is the
 * command, its first output the answer. */
static void panic(const char *name, const char *guid, const Plan *p) {
    Component one = instantiate(name, 1, guid, ""), other = instantiate("other", 1, guid, "");
    uint32_t command = p->references[0], answer = p->references[p->inputs];
    double value = 1.0;
    fprintf(out, "i %d %d\n", initialize(one), initialize(other));
    fprintf(out, "s %d %d\n", DoStep(one, 0.0, 0.1, 1), DoStep(other, 0.0, 0.1, 1));
    fprintf(out, "s %d\n", SetReal(one, &command, 1, &value));
    fprintf(out, "s %d\n", GetReal(one, &answer, 1, &value));
    fprintf(out, "s %d\n", DoStep(one, 0.1, 0.1, 1));
    fprintf(out, "s %d\n", DoStep(other, 0.1, 0.1, 1));
    fprintf(out, "s %d", GetReal(other, &answer, 1, &value));
    numbers(&value, 1);
    fputs("\n", out);
    FreeInstance(one);
    FreeInstance(other);
}

/* Reads a file named by a String through resource locations. The plan is text: value reference, location,
 * file; separated by tabs. */
static void locations(const char *guid, const char *path) {
    char line[8192];
    FILE *file = fopen(path, "rb");
    if (!file) {
        fail("the plan cannot be read", path);
    }
    while (fgets(line, sizeof line, file)) {
        char *reference = strtok(line, "\t\n"), *place = strtok(NULL, "\t\n"), *name = strtok(NULL, "\t\n");
        uint32_t variable = (uint32_t)strtoul(reference, NULL, 10);
        Component c = instantiate("reader", 1, guid, place);
        int set = SetString(c, &variable, 1, (const char *const *)&name);
        fprintf(out, "p %d %d %s %s\n", set, initialize(c), place, name);
        FreeInstance(c);
    }
    fclose(file);
}

int main(int count, char **arguments) {
    char line[4096];
    FILE *jobs = count == 2 ? fopen(arguments[1], "rb") : NULL;
    if (!jobs) {
        fail("usage", "driver jobs.txt");
    }
    while (fgets(line, sizeof line, jobs)) {
        char *kind = strtok(line, "\t\n"), *library = strtok(NULL, "\t\n"), *guid = strtok(NULL, "\t\n");
        char *plans = strtok(NULL, "\t\n"), *results = strtok(NULL, "\t\n");
        out = fopen(results, "wb");
        if (!out) {
            fail("the results cannot be written", results);
        }
        load(library);
        if (!strcmp(kind, "locations")) {
            locations(guid, plans);
        } else {
            Plan p = plan(plans);
            if (!strcmp(kind, "panic")) {
                panic("one", guid, &p);
            } else {
                co_simulation("instance", guid, &p);
                model_exchange("instance", guid, &p);
            }
        }
        fclose(out);
    }
    return 0;
}

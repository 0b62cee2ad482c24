/* The reference: a chain of FMUs stepped by a plain C loop: set, step, get, nothing else.
 * With GUARD also the check of the floating-point environment, on x86-64.
 * usage: chain LIBRARY LENGTH STEPS; prints nanoseconds of processor time per FMU-step. */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef void *Component;

/* Whether the floating-point environment is as it was: what the master checks after each step
 * (fmi::guard::Steady). */
#ifdef GUARD
#include <emmintrin.h>
static unsigned short x87_before = 0x37f;
static __m128i sums_before;
static inline __m128i sums(void) {
  const float part = 0x1.8p-24f, tiny = 0x1p-126f;
  __m128 sums = _mm_set_ps(1, -1, tiny, 0x1p-149f);
  __asm__ volatile("addps %1, %0" : "+x"(sums) : "x"(_mm_set_ps(part, -part, -1.5f * tiny, 0)));
  return _mm_castps_si128(sums);
}
static inline int changed(void) {
  unsigned short x87;
  __asm__ volatile("fnstcw %0" : "=m"(x87));
  return x87 != x87_before || _mm_movemask_epi8(_mm_cmpeq_epi32(sums(), sums_before)) != 0xffff;
}
#else
#define changed() 0
#endif

int main(int count, char **arguments) {
  void *library = dlopen(arguments[1], RTLD_NOW);
  int length = atoi(arguments[2]);
  long steps = atol(arguments[3]);
  if (!library) return 1;
  Component (*instantiate)() = (Component(*)())dlsym(library, "fmi2Instantiate");
  int (*enter)(Component) = (int (*)(Component))dlsym(library, "fmi2EnterInitializationMode");
  int (*leave)(Component) = (int (*)(Component))dlsym(library, "fmi2ExitInitializationMode");
  int (*set)(Component, const unsigned *, size_t, const double *) = dlsym(library, "fmi2SetReal");
  int (*get)(Component, const unsigned *, size_t, double *) = dlsym(library, "fmi2GetReal");
  int (*step)(Component, double, double, int) = dlsym(library, "fmi2DoStep");
  Component *chain = calloc(length, sizeof *chain);
  for (int c = 0; c < length; c++) {
    chain[c] = instantiate("element", 1, "{element}", "file:///", NULL, 0, 0);
    if (!chain[c]) return 2;
    enter(chain[c]);
    leave(chain[c]);
  }
#ifdef GUARD
  sums_before = sums();
#endif
  const unsigned u = 0, y = 2;
  double value = 1;
  struct timespec begun, ended;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &begun);
  for (long k = 0; k < steps; k++)
    for (int c = 0; c < length; c++) {
      if (set(chain[c], &u, 1, &value)) return 3;
      if (step(chain[c], k * 1e-3, 1e-3, 1)) return 4;
      if (get(chain[c], &y, 1, &value)) return 5;
      if (changed()) return 6;
    }
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &ended);
  double ns = (ended.tv_sec - begun.tv_sec) * 1e9 + (ended.tv_nsec - begun.tv_nsec);
  printf("%f\n", ns / steps / length);
  return 0;
}

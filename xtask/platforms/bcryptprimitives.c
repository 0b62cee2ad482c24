/* bcryptprimitives.dll for Wine 8 and 9, which lack it: Rust's standard library uses it for random bytes to
 * seed hash tables. Later versions and Windows have their own. */

#include <stddef.h>

__declspec(dllimport) unsigned char __stdcall SystemFunction036(void *bytes, unsigned long count);

__declspec(dllexport) int __stdcall ProcessPrng(unsigned char *bytes, size_t count) {
    return SystemFunction036(bytes, (unsigned long)count);
}

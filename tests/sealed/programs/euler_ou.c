/* Euler's scheme for dx = -x dt + 0.7 dW, x(0) = 1, with random numbers of its own; for a little-endian machine. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint64_t state;

static double uniform(void) { /* splitmix64 (Steele, Lea & Flood 2014), between 0 and 1 */
    uint64_t z = (state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return ((double)((z ^ (z >> 31)) >> 11) + 0.5) / 9007199254740992.0;
}

static double normal(void) { /* Box & Muller 1958 */
    return sqrt(-2.0 * log(uniform())) * cos(6.283185307179586 * uniform());
}

int main(int argc, char **argv) {
    double h = 0.0, T = 0.0;
    long paths = 0;
    for (int i = 1; i < argc; i++) {
        if (!strncmp(argv[i], "h=", 2)) h = atof(argv[i] + 2);
        if (!strncmp(argv[i], "T=", 2)) T = atof(argv[i] + 2);
        if (!strncmp(argv[i], "paths=", 6)) paths = atol(argv[i] + 6);
        if (!strncmp(argv[i], "seed=", 5)) state = strtoull(argv[i] + 5, NULL, 10);
    }
    for (long path = 0; path < paths; path++) {
        double x = 1.0;
        for (long step = lround(T / h); step > 0; step--) x += -h * x + 0.7 * sqrt(h) * normal();
        fwrite(&x, sizeof x, 1, stdout);
    }
    return 0;
}

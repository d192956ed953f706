/* Milstein's scheme for one Brownian motion: x + h f + B dW + DB B (dW^2 - h)/2; with -DSIGN=- a wrong one. */
#include "sdaeverify.h"
#ifndef SIGN
#define SIGN +
#endif
static const char *hello = "name wired-milstein\nform SDE\nnoise dW\nneeds scalar-noise\n"
    "asks drift diffusion derivative_of_diffusion\nsource Milstein 1974\n"
    "claim strong 1.0 source Kloeden & Platen 1992, Theorem 10.3.5\n"
    "claim weak 1.0 source Kloeden & Platen 1992, section 14.1\n";

static const double *ask(const char *words, long d, long P, const double *y) {
    sv_begin(words);
    sv_put("t", sv_get("t"), -1, 1);
    sv_put("x", sv_get("x"), d, P);
    if (y) sv_put("y", y, d, P);
    return sv_ask();
}

int main(void) {
    while (sv_next(hello)) {
        long n = sv_size("x"), P = sv_paths("x"), d = n / P, i;
        const double h = *sv_get("h"), *x = sv_get("x"), *dW = sv_get("dW");
        const double *f = ask("ask drift", d, P, 0), *B = ask("ask diffusion", d, P, 0);
        const double *DB = ask("ask derivative_of_diffusion", d, P, B);
        double *y = (double *)malloc(8 * n);
        for (i = 0; i < n; i++) {
            double w = dW[i % P];
            y[i] = x[i] + h * f[i] + B[i] * w SIGN DB[i] * (0.5 * (w * w - h));
        }
        sv_begin("done");
        sv_put("x", y, d, P);
        sv_send();
        free(y);
    }
    return 0;
}

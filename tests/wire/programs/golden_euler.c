/* Euler's scheme in C and C++, which answers as the golden transcript does. */
#include "sdaeverify.h"
#ifdef WRONG
#define STEP (2.0 * h)
#else
#define STEP h
#endif
int main(void) {
    while (sv_next("name golden-euler\nform SDE\nnoise dW\nasks drift diffusion\n")) {
        long n = sv_size("x"), P = sv_paths("x"), d = n / P, l = sv_size("dW") / P;
        double h = *sv_get("h"), *t = sv_get("t"), *x = sv_get("x"), *dW = sv_get("dW"), *f, *B;
        double *y = (double *)malloc(8 * n);
        sv_begin("ask drift"); sv_put("t", t, -1, 1); sv_put("x", x, d, P); f = sv_ask();
        sv_begin("ask diffusion"); sv_put("t", t, -1, 1); sv_put("x", x, d, P); B = sv_ask();
        for (long i = 0; i < n; i++) {
            y[i] = x[i] + STEP * f[i];
            for (long j = 0; j < l; j++) y[i] += B[(i / P * l + j) * P + i % P] * dW[j * P + i % P];
        }
        sv_begin("done"); sv_put("x", y, d, P); sv_send();
        free(y);
    }
    return 0;
}

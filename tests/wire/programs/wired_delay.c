/* Euler's scheme for delay equations of index 1: x+ = x + h f + g dW, y+ of the constraint at the end of the step. */
#include "sdaeverify.h"
static const char *hello = "name wired-delay\nform DelaySDAE\nnoise dW\nasks drift diffused eliminated\n"
    "claim strong 0.5 source measured\nclaim weak 1.0 source measured\n";
static long d, q, P;

static const double *ask(const char *words, const double *w, long l) {
    sv_begin(words);
    sv_put("t", sv_get("t"), -1, 1);
    sv_put("x", sv_get("x"), d, P);
    sv_put("v", sv_get("lagged"), d, P);
    sv_put("y", sv_get("y"), q, P);
    if (w) sv_put("w", w, l, P);
    return sv_ask();
}

int main(void) {
    while (sv_next(hello)) {
        const double h = *sv_get("h"), weight = *sv_get("weight"), end = *sv_get("t") + h;
        const double *x = sv_get("x"), *dW = sv_get("dW"), *ahead = sv_get("ahead"), *y = sv_get("y"), *f, *kick;
        double *new, *v;
        long i;
        P = sv_paths("x"), d = sv_size("x") / P, q = sv_size("y") / P;
        new = (double *)malloc(8 * d * P), v = (double *)malloc(8 * d * P);
        f = ask("ask drift", 0, 0), kick = ask("ask diffused", dW, sv_size("dW") / P);
        for (i = 0; i < d * P; i++) {
            new[i] = x[i] + h * f[i] + kick[i];
            v[i] = weight == 0.0 ? ahead[i] : ahead[i] + weight * new[i];
        }
        if (q) {
            sv_begin("ask eliminated");
            sv_put("t", &end, -1, 1);
            sv_put("x", new, d, P);
            sv_put("v", v, d, P);
            y = sv_ask();
        }
        sv_begin("done");
        sv_put("x", new, d, P);
        sv_put("y", y, q, P);
        sv_send();
        free(new), free(v);
    }
    return 0;
}

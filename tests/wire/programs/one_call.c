/* One step of Milstein's scheme a call: h as the argument; x, f, B, DB B and dW of P paths on stdin; x+ on stdout. */
#include <stdio.h>
#include <stdlib.h>

int main(int count, char **words) {
    double h = count > 1 ? atof(words[1]) : 0.0, a[5];
    long P = count > 2 ? atol(words[2]) : 0, p, k;
    double *all = (double *)malloc(5 * 8 * P);
    if (!all || fread(all, 8, 5 * P, stdin) != (size_t)(5 * P)) return 1;
    for (p = 0; p < P; p++) {
        for (k = 0; k < 5; k++) a[k] = all[k * P + p];
        a[0] += h * a[1] + a[2] * a[4] + 0.5 * a[3] * (a[4] * a[4] - h);
        fwrite(a, 8, 1, stdout);
    }
    return 0;
}

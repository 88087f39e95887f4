/* Balances a pole on a cart: the law u = -k (y - upright) every millisecond, between them a step of
   Runge and Kutta's method with the equations of motion in cart_pole.c. Usage: balance k1 k2 k3 k4 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "cart_pole.h"

enum { N = cart_pole_nq + cart_pole_nv };

static void step(double t, double h, const double tau[], double y[N])
{
    const double part[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0, 2.0, 2.0, 1.0};
    double slope[N] = {0.0}, sum[N] = {0.0}, stage[N];
    for (int s = 0; s < 4; s++) {
        for (int i = 0; i < N; i++) stage[i] = y[i] + part[s] * h * slope[i];
        cart_pole_rhs(t + part[s] * h, stage, tau, NULL, slope);
        for (int i = 0; i < N; i++) sum[i] += weight[s] / 6.0 * slope[i];
    }
    for (int i = 0; i < N; i++) y[i] += h * sum[i];
}

int main(int count, char **words)
{
    const double pi = acos(-1.0), h = 1e-3, upright[N] = {0.0, pi, 0.0, 0.0};
    double y[N] = {0.5, pi - 0.4, 0.0, 0.0}, energy[2];
    if (count != N + 1) return EXIT_FAILURE;
    for (int k = 0; k <= 12000; k++) {
        double tau[cart_pole_nv] = {0.0};
        for (int i = 0; i < N; i++) tau[0] -= atof(words[i + 1]) * (y[i] - upright[i]);
        if (k % 1000 == 0) {
            cart_pole_energy(k * h, y, y + cart_pole_nq, NULL, energy);
            printf("t = %.0f s: cart at %+.5f m, pole %+.5f rad from upright, push %+.3f N, %.3f J\n",
                   k * h, y[0], y[1] - pi, tau[0], energy[0] + energy[1]);
        }
        step(k * h, h, tau, y);
    }
    return fabs(y[1] - pi) < 1e-3 ? EXIT_SUCCESS : EXIT_FAILURE;
}

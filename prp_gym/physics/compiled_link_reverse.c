/* Exact derivatives of a time step and of the measurement of one link; see compiled_arm_reverse.c. */

void prp_step_reverse(
    const prp_world *world, const double *q, const double *v, const double *tau, const double *plant,
    const double *surface, const double *d_later, const double *d_faster, double *d_q, double *d_v,
    double *d_tau)
{
    (void)world, (void)surface;
    prp_link_step_transposed(q, v, tau, plant, d_later, d_faster, d_q, d_v, d_tau);
}

void prp_measured_reverse(
    const prp_world *world, const double *q, const double *v, const double *tau, const double *plant,
    const double *surface, const double *d_measured, double *d_q, double *d_v, double *d_tau)
{
    (void)world, (void)q, (void)v, (void)tau, (void)plant, (void)surface;
    *d_q = d_measured[0], *d_v = d_measured[1], *d_tau = 0.0;
}

/* What MuJoCo's batch has measured, in one look at its arrays. */

typedef struct {
    const double *sensors, *gain, *offset, *bound;
    const int *warnings;
    long rows, sensor_count, measured_count, joints, first_stop, warning_kinds, warning_stride;
    int no_warning;
} prp_readings;

/* Whether a simulation has left its bounds, or MuJoCo has reset it. */
static inline int prp_has_left(const prp_readings *from, const double *sensors, const double *bound, long row)
{
    const int *warnings = from->warnings + from->warning_stride * row;
    int left = 0;
    for (long i = 0; i < 2 * from->joints; i++)
        left |= fabs(sensors[i]) > bound[i];
    for (long i = 0; i < from->warning_kinds; i++) /* a counter follows the information on the last one */
        left |= warnings[2 * i] != from->no_warning;
    return left;
}

/* Measurements and stop violations of all simulations; nothing and 0 if one of them has left its bounds. */
int prp_read(const prp_readings *from, double *measured, double *beyond)
{
    for (long row = 0; row < from->rows; row++) {
        const long first = from->sensor_count * row;
        if (prp_has_left(from, from->sensors + first, from->bound + first, row))
            return 0;
    }
    for (long row = 0; row < from->rows; row++) {
        const double *sensors = from->sensors + from->sensor_count * row;
        double *values = measured + from->measured_count * row, *stops = beyond + from->joints * row;
        for (long i = 0; i < from->measured_count; i++)
            values[i] = sensors[i] * from->gain[from->measured_count * row + i]
                + from->offset[from->measured_count * row + i];
        for (long i = 0; i < from->joints; i++)
            stops[i] = from->first_stop < 0 ? 0.0 : sensors[from->first_stop + i];
    }
    return 1;
}

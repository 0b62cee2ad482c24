//! The message types as ROS 2 defines them, without comments.

/// Types by name; names of nested types are complete.
const TYPES: [(&str, &str); 17] = [
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"),
    ("geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"),
    ("geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n"),
    ("geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"),
    ("geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist\nfloat64[36] covariance\n"),
    (
        "geometry_msgs/PoseWithCovarianceStamped",
        "std_msgs/Header header\ngeometry_msgs/PoseWithCovariance pose\n",
    ),
    (
        "geometry_msgs/TwistWithCovarianceStamped",
        "std_msgs/Header header\ngeometry_msgs/TwistWithCovariance twist\n",
    ),
    (
        "geometry_msgs/Transform",
        "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
    ),
    (
        "geometry_msgs/TransformStamped",
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
    ),
    ("tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"),
    (
        "nav_msgs/Odometry",
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n\
         geometry_msgs/TwistWithCovariance twist\n",
    ),
    (
        "sensor_msgs/Imu",
        "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n\
         float64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\n\
         float64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\n\
         float64[9] linear_acceleration_covariance\n",
    ),
    (
        "sensor_msgs/FluidPressure",
        "std_msgs/Header header\nfloat64 fluid_pressure\nfloat64 variance\n",
    ),
];

/// The definition of, for example, `nav_msgs/msg/Odometry`, followed by those of all nested types.
pub(super) fn of(name: &str) -> String {
    let name = name.replace("/msg/", "/");
    let text = |name: &str| TYPES.iter().find(|(known, _)| *known == name).map(|(_, text)| *text);
    let mut within: Vec<&str> = vec![&name];
    let mut at = 0;
    let mut whole = String::new();
    while let Some(&name) = within.get(at) {
        let Some(own) = text(name) else { break };
        if at > 0 {
            whole += &format!("{}\nMSG: {name}\n", "=".repeat(80));
        }
        whole += own;
        for line in own.lines() {
            let kind = line.split([' ', '[']).next().unwrap_or_default();
            if kind.contains('/') && !within.contains(&kind) {
                within.push(kind);
            }
        }
        at += 1;
    }
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_definition_has_every_type_that_it_needs() {
        for (name, _) in TYPES {
            let whole = of(name);
            let known = |kind: &str| kind == name || whole.contains(&format!("MSG: {kind}\n"));
            let kinds = whole.lines().filter_map(|line| line.split([' ', '[']).next());
            for kind in kinds.filter(|kind| kind.contains('/')) {
                assert!(known(kind), "{name} lacks {kind}");
            }
        }
    }
}

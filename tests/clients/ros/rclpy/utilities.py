def remove_ros_args(args):
    return list(args)

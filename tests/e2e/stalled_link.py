"""A link that can be stalled. Data sent meanwhile arrive when it is released."""
import socket
import threading


class StalledLink:
    """Listens on a free port and forwards to `target` (HOST:PORT)."""

    def __init__(self, target):
        host, port = target.rsplit(":", 1)
        self.target = (host, int(port))
        self.moves = threading.Event()
        self.moves.set()

    def __enter__(self):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.address = "127.0.0.1:%d" % self.listener.getsockname()[1]
        self.sockets = []
        threading.Thread(target=self._accept, daemon=True).start()
        return self

    def __exit__(self, *error):
        self.release()
        self.listener.close()
        self.cut()

    def stall(self):
        self.moves.clear()

    def release(self):
        self.moves.set()

    def cut(self):
        """Closes all connections. New ones are accepted."""
        for each in self.sockets:
            try:
                each.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
        self.sockets = []

    def _accept(self):
        try:
            while True:
                near, _ = self.listener.accept()
                far = socket.create_connection(self.target)
                self.sockets += [near, far]
                for source, sink in (near, far), (far, near):
                    source.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                    threading.Thread(target=self._carry, args=(source, sink), daemon=True).start()
        except OSError:
            pass

    def _carry(self, source, sink):
        try:
            while data := source.recv(65536):
                self.moves.wait()
                sink.sendall(data)
        except OSError:
            pass
        for each in source, sink:
            try:
                each.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
        source.close()  # the thread of the other direction closes `sink`
